"""The control of the plant's run: hold, step, restart."""

from collections.abc import Callable

from mobile_robot_control.configuration.nodes import PlantParameters
from mobile_robot_control.stamps import period_nanoseconds

_NOT_HELD = 'the run is not held: set the parameter paused to true first'
_WALL_CLOCK = 'on the wall clock time goes on by itself; it can be stepped in lockstep, with lockstep: true'


class RunControl:
    """
    Decides whether time stands still, and when a new run begins; on the wall clock.

    Parameters
    ----------
    values : PlantParameters
        Initial parameters.
    now : callable
        Returns the simulated time [ns].
    go_on : callable
        Called when a held run may move.
    begin_anew : callable
        Begins a new run at once.

    """

    def __init__(
        self, values: PlantParameters, now: Callable[[], int], go_on: Callable[[], None],
        begin_anew: Callable[[], None],
    ) -> None:
        self._values, self._now, self._go_on, self._begin_anew = values, now, go_on, begin_anew

    @property
    def held(self) -> bool:
        """Whether time stands still by `paused` or `hold_at`."""
        return self._values.paused or 0 < round(self._values.hold_at * 1e9) <= self._now()

    def change(self, values: PlantParameters) -> None:
        """Apply parameters after a live change, and resume the run if they no longer hold it."""
        held = self.held
        self._values = values
        if held and not self.held:
            self._go_on()

    def reset(self) -> tuple[bool, str]:
        """Begin a new run at once; return whether that succeeded, with a text."""
        self._begin_anew()
        return True, f'the robot stands at {self._pose()}; on the wall clock the other nodes go on as they are'

    def step(self) -> tuple[bool, str]:
        """Refuse to step; return the reason."""
        return False, _WALL_CLOCK

    def _pose(self) -> list[float]:
        return [round(value, 4) for value in self._values.initial_pose]


class LockstepRunControl(RunControl):
    """RunControl in lockstep: a new run begins where every node accepts stamp 0 as its start."""

    def __init__(
        self, values: PlantParameters, now: Callable[[], int], go_on: Callable[[], None],
        begin_anew: Callable[[], None],
    ) -> None:
        super().__init__(values, now, go_on, begin_anew)
        self._period = period_nanoseconds(values.shared.position_rate)
        self._goal = 0
        self._reset_asked = False

    @property
    def held(self) -> bool:
        """Whether time stands still, and is not on its way to a reset or the end of a step."""
        return super().held and not self._reset_asked and self._now() >= self._goal

    def begins_anew(self) -> bool:
        """
        Return whether a new run begins now, in place of a step.

        A requested run begins at an answered position tick other than the first. By then every node has accepted a
        stamp other than 0, so stamp 0 begins a new run in each, and no command of stamp 0 is stored. Topics keep the
        order of each publisher, so no message of stamp 0 from the previous run can follow.
        """
        return self._reset_asked and self._reset_at == self._now()

    def note_new_run(self) -> None:
        """Note the start of a new run at 0."""
        self._reset_asked, self._goal = False, 0

    @property
    def _reset_at(self) -> int:
        """The first position tick, from now on, at which a new run may begin [ns]."""
        return max(1, -(-self._now() // self._period)) * self._period

    def reset(self) -> tuple[bool, str]:
        """Request a new run; return whether it will begin, and when, as a text."""
        message = f'a new run from {self._pose()} begins after t = {self._reset_at / 1e9:g} s'
        held, self._reset_asked = self.held, True
        if held:
            self._go_on()
        return True, message

    def step(self) -> tuple[bool, str]:
        """Let a held run advance to the next position tick; return whether it does, and how far, as a text."""
        if not super().held:
            return False, _NOT_HELD
        held = self.held
        goal = max(self._goal, self._now())
        self._goal = (goal // self._period + 1) * self._period
        if held:
            self._go_on()
        return True, f'time goes on to t = {self._goal / 1e9:g} s'
