"""The course of the plant's run: held, stepped while it is held, begun anew."""

from collections.abc import Callable

from mobile_robot_control.configuration.nodes import PlantParameters
from mobile_robot_control.stamps import period_nanoseconds

_NOT_HELD = 'the run is not held: set the parameter paused to true first'
_WALL_CLOCK = 'on the wall clock time goes on by itself; it can be stepped in lockstep, with lockstep: true'


class RunControl:
    """
    Decides whether time stands still, and where a new run begins; on the wall clock.

    Parameters
    ----------
    values : PlantParameters
        What it was started with.
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
        """Take the parameters after a live change, and let the run go on where they do not hold it any more."""
        held = self.held
        self._values = values
        if held and not self.held:
            self._go_on()

    def reset(self) -> tuple[bool, str]:
        """Begin a new run at once; return whether that is done, in words too."""
        self._begin_anew()
        return True, f'the robot stands at {self._pose()}; on the wall clock the other nodes go on as they are'

    def step(self) -> tuple[bool, str]:
        """Refuse to step; return why."""
        return False, _WALL_CLOCK

    def _pose(self) -> list[float]:
        return [round(value, 4) for value in self._values.initial_pose]


class LockstepRunControl(RunControl):
    """As RunControl, in lockstep: a new run begins where every node takes stamp 0 for one."""

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
        Return whether a new run begins in the place of the step from now.

        It does where one is asked for, at an answered position tick but the first: by then every node has accepted a
        stamp other than 0, so that stamp 0 begins a new run in each, and no command of stamp 0 is kept. Since topics
        keep the order of each publisher, no message of stamp 0 can follow from the run that ends.
        """
        return self._reset_asked and self._reset_at == self._now()

    def note_new_run(self) -> None:
        """Note that a new run begins at 0."""
        self._reset_asked, self._goal = False, 0

    @property
    def _reset_at(self) -> int:
        """The first position tick, from now on, at which a new run may begin [ns]."""
        return max(1, -(-self._now() // self._period)) * self._period

    def reset(self) -> tuple[bool, str]:
        """Ask for a new run; return whether it will begin, and when in words."""
        message = f'a new run from {self._pose()} begins after t = {self._reset_at / 1e9:g} s'
        held, self._reset_asked = self.held, True
        if held:
            self._go_on()
        return True, message

    def step(self) -> tuple[bool, str]:
        """Let a held run go on to the next position tick; return whether it does, and how far in words."""
        if not super().held:
            return False, _NOT_HELD
        held = self.held
        goal = max(self._goal, self._now())
        self._goal = (goal // self._period + 1) * self._period
        if held:
            self._go_on()
        return True, f'time goes on to t = {self._goal / 1e9:g} s'
