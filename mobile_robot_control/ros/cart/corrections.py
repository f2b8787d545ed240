"""The corrections of a localisation, as the cart follows them: they place it, or lead it over."""

from typing import Any

from mobile_robot_control.quantities import NANOSECONDS, Pose
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.reference.localisation import Corrections, apart, composed
from mobile_robot_control.ros.cart.parts import Cart
from mobile_robot_control.ros.shared.localisation import LocalisationInput
from mobile_robot_control.topics import CORRECTION

_MOST = 1000
"""Most corrections that wait for their ticks."""


class NoCorrections:
    """The path lies in the frame of odometry."""

    used: Pose | None = None

    def begin_run(self) -> None:
        """Await nothing."""

    def step(self, stamp: int) -> None:
        """Correct nothing."""

    def report(self, stamp: int) -> None:
        """Report nothing."""

    def missing_correction(self) -> str:
        """Return '': nothing is missing."""
        return ''

    def show_errors(self) -> None:
        """Show nothing: there is one frame."""


class CartCorrections:
    """
    Uses each correction at the first tick that is not before it: by stamps, or by times of receipt.

    Parameters
    ----------
    cart : Cart
        The node.
    mode : LockstepCart or WallClockCart
        Tells the time of a correction.

    Attributes
    ----------
    used : Pose or None
        The correction in use; None before the first.

    """

    def __init__(self, cart: Cart, mode: Any) -> None:
        self._cart, self._mode = cart, mode
        self._waiting: list[tuple[int, Pose]] = []
        self._choice = Corrections()
        self._led: Pose | None = None
        self._input = LocalisationInput(cart, cart.shared, cart.validator, self.take_correction)

    @property
    def used(self) -> Pose | None:
        """The correction in use."""
        return self._choice.used

    def begin_run(self) -> None:
        """Begin a run: in lockstep each awaits its own correction, and those that wait are of it."""
        if self._mode.forgets_corrections:
            self._choice = Corrections()
            self._input.forget_transforms()

    def take_correction(self, stamp: int, correction: Pose) -> None:
        """Store a correction with its stamp [ns]."""
        self._waiting = sorted([*self._waiting, (self._mode.clock(stamp), correction)])[-_MOST:]

    def missing_correction(self) -> str:
        """Return why nothing leads from the frame of the path to odometry now; '' if something does."""
        return self._input.missing_correction(self._cart.parameters.localisation.timeout)

    def _due(self, now: int, at: Pose) -> Pose | None:
        """
        Return the correction to use from a time [ns] on, for a cart at a pose of odometry; None if it stays.

        At the first tick of a run in lockstep it stays: nothing could lead a replay there.
        """
        if now == 0:
            return None
        for since, correction in [one for one in self._waiting if one[0] <= now]:
            self._choice.note_correction(since, correction, at)
        self._waiting = [one for one in self._waiting if one[0] > now]
        return self._choice.due(now, at)

    def step(self, stamp: int) -> None:
        """Use a correction that is due: place the cart, or lead it over."""
        cart, course = self._cart, self._cart.course
        now = cart.now
        correction = self._due(self._mode.clock(stamp), course.reference(now / NANOSECONDS).pose)
        if correction is None:
            return
        if course.correction is None:
            course.place(correction, now)
            cart.time.begin_curve()
        elif cart.parameters.curve.curve != PATH:
            course.lead_over(correction, now)
        elif course.can_be_led(now):
            cart.paths.correct(correction)
            return
        elif cart.paths.plans():
            return
        else:
            # a cart that stands, or stops, takes it for its next path
            course.correction = correction
        self.note_led(correction)

    def note_led(self, correction: Pose) -> None:
        """Note the correction that the cart uses from this step on."""
        self._choice.used = self._led = correction

    def report(self, stamp: int) -> None:
        """Report a correction that acts from a step [ns] on."""
        led, self._led = self._led, None
        if led is not None:
            self._cart.publish_path()
            self._cart.publish_event(stamp, {CORRECTION: led})

    def show_errors(self) -> None:
        """Show the robot's distance from the cart in both frames, which differ until the cart has led over."""
        cart, used, newest = self._cart, self._choice.used, self._choice.newest
        if used is None or newest is None:
            return
        at = cart.reference.pose
        outer = apart(composed(newest, cart.pose), composed(used, at))[0]
        cart.tell({f'error in {cart.shared.path_frame_id} [m]': f'{outer:.4f}',
                   f'error in {cart.shared.odom_frame_id} [m]': f'{apart(cart.pose, at)[0]:.4f}'})
