"""The course of the reference cart: its curve, changed while it drives."""

from mobile_robot_control.configuration.nodes import ReferenceCartParameters
from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.reference.cart import (
    CurveParameters,
    accelerated_at,
    reference_at,
    references_along,
    with_period,
)
from mobile_robot_control.reference.curves import CURVES

_PATH_POINTS = 400
PERIOD = 'period'
"""The parameter that acts without a jump of the cart."""


class CartCourse:
    """
    Where the cart is at a time along its curve.

    Parameters
    ----------
    curve : CurveParameters
        Checked.
    horizon : int
        Position ticks ahead.
    period : int
        Of the position loop [ns].

    """

    def __init__(self, curve: CurveParameters, horizon: int, period: int) -> None:
        self._horizon, self._period = horizon, period
        self.begin(curve)

    def begin(self, curve: CurveParameters) -> None:
        """Begin a run on a curve."""
        self._given = curve
        self._curve, self._placement = CURVES[curve.curve], curve.placement

    def is_new(self, curve: CurveParameters) -> bool:
        """Return whether a run on a curve would leave this one."""
        return curve != self._given

    def change_period(self, values: ReferenceCartParameters, time: float) -> None:
        """Take the lap time of changed parameters, at a time along the curve [s]: the cart goes on where it is."""
        period = values.curve.placement.period
        if period != self._placement.period:
            self._placement = with_period(self._placement, period, time)
            self._given = self._given._replace(placement=self._given.placement._replace(period=period))

    def reference(self, time: float) -> Reference:
        """Return the reference at a time along the curve [s]."""
        at = accelerated_at if self._horizon else reference_at
        return at(self._curve, time, self._placement)

    def references(self, time: int) -> tuple[Reference, ...]:
        """Return the reference at a time along the curve [ns] and at the ticks of the horizon."""
        return references_along(self._curve, self._placement, self._horizon)(time, self._period)

    def lap(self) -> list[Pose]:
        """Return the poses of one lap."""
        period = self._placement.period
        return [reference_at(self._curve, period * n / _PATH_POINTS, self._placement).pose
                for n in range(_PATH_POINTS + 1)]
