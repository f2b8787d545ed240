"""The references ahead of a time."""

from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.course import CurveCourse, references_along
from mobile_robot_control.reference.curves import CurvePoint

PLACED = Placement(scale=1.3, period=9.0, phase=0.2, center=(1.0, -2.0), rotation=0.7)


def counted(asked):
    """Return a line that notes what it is asked for."""
    def line(s):
        asked.append(s)
        return CurvePoint(s, 0.0, 1.0, 0.0, 0.0, 0.0)

    return line


def test_without_a_horizon_nothing_is_computed():
    asked = []
    once = counted(asked)
    assert references_along(CurveCourse(once, PLACED), 0)(10**9, 10**7) == (reference_at(once, 1.0, PLACED),)
    assert len(asked) == 2
    assert len(references_along(CurveCourse(once, PLACED), 2)(10**9, 10**7)) == 3


def test_each_tick_of_a_horizon_is_computed_once_and_is_the_course_at_its_time():
    asked, there = [], []
    course, plain = CurveCourse(counted(asked), PLACED), CurveCourse(counted(there), PLACED)
    references_at, tick = references_along(course, 20), 10**7
    for n in range(50):
        assert references_at(n * tick, tick)[::20] == tuple(
            plain.accelerated((n + ahead) * tick / 1e9) for ahead in (0, 20))
    # 70 ticks beside 100
    assert len(asked) / 70 == len(there) / 100 > 0.0
