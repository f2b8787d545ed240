"""The references ahead of a time."""

from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.course import CurveCourse, references_along
from mobile_robot_control.reference.curves import CurvePoint

PLACED = Placement(scale=1.3, period=9.0, phase=0.2, center=(1.0, -2.0), rotation=0.7)


def test_without_a_horizon_nothing_is_computed():
    def once(s):
        asked.append(s)
        return CurvePoint(s, 0.0, 1.0, 0.0, 0.0, 0.0)

    asked = []
    assert references_along(CurveCourse(once, PLACED), 0)(10**9, 10**7) == (reference_at(once, 1.0, PLACED),)
    assert len(asked) == 2
    assert len(references_along(CurveCourse(once, PLACED), 2)(10**9, 10**7)) == 3
