"""The numbers of drives along paths, by hand."""

import math

import numpy as np
import pytest

from mobile_robot_control.drives.drive_metrics import DrivenMotion, drive_metrics, places_on

NO_COMMANDS = np.zeros((0, 2))


def along(points, speed=0.5, rate=50.0, omega=0.0):
    """A motion at constant speed through points."""
    ways = np.hypot(*np.diff(points, axis=0).T)
    lengths = np.concatenate([[0.0], np.cumsum(ways)])
    time = np.arange(0.0, lengths[-1] / speed + 0.5 / rate, 1.0 / rate)
    xy = np.column_stack([np.interp(time * speed, lengths, column) for column in np.array(points).T])
    pose = np.column_stack([xy, np.zeros(time.size)])
    return DrivenMotion(time, pose, np.column_stack([np.full(time.size, speed), np.full(time.size, omega)]))


def path_of(points, heading=math.nan):
    """A path with one heading."""
    return np.column_stack([points, np.full(len(points), heading)])


def measured(path, motion, commands=NO_COMMANDS, half=0.2):
    """The metrics of a motion."""
    return drive_metrics(path, motion, places_on(path, motion), commands, half)


def test_a_drive_beside_a_straight_path_has_the_numbers_of_the_hand():
    motion = along([(0.0, 0.1), (2.0, 0.1)])
    found = measured(path_of([(0.0, 0.0), (2.0, 0.0)], 0.2), motion, np.array([[0.5, 0.0], [0.5, 1.0]]))
    assert found.rms_cross_track_error == pytest.approx(0.1)
    assert found.max_cross_track_error == pytest.approx(0.1)
    assert (found.progress, found.path_length, found.driven) == pytest.approx((2.0, 2.0, 2.0))
    assert (found.mean_speed, found.max_speed) == pytest.approx((0.5, 0.5))
    assert (found.stops, found.standing, found.heading_oscillation) == (0.0, 0.0, 0.0)
    # both rims by 0.5 m/s, then one by 0.2 up and the other down
    assert found.command_variation == pytest.approx(1.4)
    assert found.time_to_goal == pytest.approx(4.0)
    assert (found.end_position_error, found.end_heading_error) == pytest.approx((0.1, 0.2))


def test_a_crossing_or_the_next_lap_is_not_taken_for_the_place():
    angle = np.linspace(0.0, 4.0 * np.pi, 801)
    eight = np.column_stack([np.sin(angle), 0.5 * np.sin(2.0 * angle)])
    motion = along(eight)
    places = places_on(path_of(eight), motion)
    assert np.abs(places.along - 0.5 * motion.time).max() < 0.02
    assert places.away.max() < 1e-3
    assert places.ambiguous == 0.0


def test_a_robot_that_leaves_out_a_loop_is_told():
    angle = np.linspace(0.0, 4.0 * np.pi, 801)
    eight = np.column_stack([np.sin(angle), 0.5 * np.sin(2.0 * angle)])
    assert places_on(path_of(eight), along(eight[400:])).ambiguous == 0.0
    cut = np.concatenate([eight[:50], eight[250:]])
    assert places_on(path_of(eight), along(cut)).ambiguous > 0.02


def test_a_pose_that_jumps_back_goes_back_on_the_path():
    motion = along([(0.0, 0.0), (1.0, 0.0)])
    motion.pose[25:, 0] -= 0.1
    assert places_on(path_of([(0.0, 0.0), (2.0, 0.0)]), motion).away.max() < 1e-12


def test_stops_and_turns_to_both_sides_are_counted():
    motion = along([(0.0, 0.0), (5.0, 0.0)])
    motion.velocity[100:150, 0] = 0.0                            # 1 s
    motion.velocity[300:310, 0] = 0.0                            # too short
    motion.velocity[:, 1] = 0.1 * np.sign(np.sin(2.0 * np.pi * motion.time))
    motion.velocity[200:, 1] = 0.04 * np.sign(motion.velocity[200:, 1])
    found = measured(path_of([(0.0, 0.0), (5.0, 0.0)]), motion)
    assert found.stops == 1.0
    assert found.standing == pytest.approx(1.0, abs=0.03)
    # four seconds with a change each half of a second
    assert found.heading_oscillation * found.driven == pytest.approx(7.0)


def test_where_nothing_is_known_the_number_is_not_a_number():
    motion = along([(0.0, 0.0), (1.0, 0.0)])
    found = measured(path_of([(0.0, 0.0), (2.0, 0.0)]), motion, half=math.nan)
    assert all(map(math.isnan, (found.command_variation, found.time_to_goal, found.end_heading_error)))
    standing = measured(path_of([(0.0, 0.0), (2.0, 0.0)]), motion._replace(velocity=0.0 * motion.velocity))
    assert math.isnan(standing.mean_speed)
    assert standing.driven == 0.0
