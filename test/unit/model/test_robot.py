"""The robot's constants: section 2.1 and Eq. (15) of the chapter."""

import chapter
import pytest

from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia


def test_the_defaults_are_the_chapters_robot():
    assert Robot() == (10.0, 1.0, 0.035, 0.35, 0.05, 0.001, 0.00715625)


def test_equation_15_with_the_chapters_numbers():
    sum_, difference = linear_inertia(Robot()), angular_inertia(Robot())
    # A and B by hand: 0.0030625 + 0.01025 + 0.001 and 0.0030625 - 0.01025
    assert 0.5 * (sum_ + difference) == pytest.approx(0.0143125, rel=1e-14)
    assert 0.5 * (sum_ - difference) == pytest.approx(-0.0071875, rel=1e-14)
    assert pytest.approx(chapter.A, rel=1e-14) == 0.5 * (sum_ + difference)
    assert pytest.approx(chapter.B, rel=1e-14) == 0.5 * (sum_ - difference)


def test_equation_15_with_other_numbers():
    # r = 1, R = 2: A + B = 4/2 + 0.5, A - B = (3 + 4 * 0.25) / 8 + 0.5
    robot = Robot(mass=4.0, inertia=3.0, wheel_radius=1.0, wheel_separation=4.0, com_offset=-0.5, wheel_inertia=0.5)
    assert linear_inertia(robot) == 2.5
    assert angular_inertia(robot) == 1.0
    assert half_separation(robot) == 2.0


def test_the_offset_of_the_mass_centre_counts_by_its_square_and_for_turning_alone():
    ahead, behind, none = (Robot(com_offset=offset) for offset in (0.1, -0.1, 0.0))
    assert angular_inertia(ahead) == angular_inertia(behind) > angular_inertia(none)
    # M d² r² / (2 R²) with r/R = 1/5
    assert angular_inertia(ahead) - angular_inertia(none) == pytest.approx(10.0 * 0.01 / 50.0, rel=1e-12)
    assert linear_inertia(ahead) == linear_inertia(none)
