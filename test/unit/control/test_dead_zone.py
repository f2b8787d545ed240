"""Small motions of a base with a dead zone: as far as asked for, in pulses, and at rest without chatter."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

import mobile_robot_control as mrc
from mobile_robot_control.control.dead_zone import DeadZone, Pulses, in_pulses
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError

ZONE, DT = DeadZone(0.13, 0.85), 0.01
MOVES = Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.1, 0.0))
STANDS = Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0))
FAR = TrackingError(0.1, 0.0, 0.1)
SMALL = st.floats(-0.12, 0.12)
GOAL = {
    'plant.drive': 'velocity', 'plant.base.dead_zone': [0.13, 0.85], 'plant.base.lag': [0.1, 0.1],
    '/**.velocity_rate': 100.0, '/**.position_rate': 100.0, 'position_controller.controller_type': 'kanayama',
    'reference_cart.curve': 'path', 'reference_cart.path.tolerance': 0.1,
    **{f'reference_cart.timing.max_{name}': value for name, value in (
        ('linear_velocity', 0.4), ('linear_acceleration', 0.5), ('angular_velocity', 1.5))},
    'position_controller.dead_zone.linear': 0.13, 'position_controller.dead_zone.angular': 0.85}


def commands(asked, error=FAR, reference=MOVES, zone=ZONE):
    """The commands for those that are asked for."""
    pulses, found = Pulses(), []
    for velocity in asked:
        pulses, command = in_pulses(pulses, velocity, error, reference, zone, DT)
        found.append(command)
    return found


@given(st.lists(SMALL, min_size=1, max_size=200))
def test_the_robot_moves_as_far_as_asked_for_within_a_pulse(values):
    found = commands([BodyVelocity(value, 5.0 * value) for value in values])
    for n, zone in enumerate(ZONE):
        asked, moved = (sum(DT * one[n] for one in way) for way in ([(v, 5.0 * v) for v in values], found))
        # with a zero that ends a pulse nothing is owed
        if all(values):
            assert abs(asked - moved) <= 2.0 * zone * DT + 1e-9


@given(st.lists(SMALL.filter(bool), min_size=1, max_size=200))
def test_each_pulse_has_two_periods_at_the_edge_of_the_zone(values):
    found = [command.linear for command in commands([BodyVelocity(value, 0.0) for value in values])]
    assert {*map(abs, found)} <= {0.0, 0.13}
    runs = ''.join('+' if one > 0.0 else '-' if one else ' ' for one in found[:-1])
    for sign in '+-':
        assert all(len(run) % 2 == 0 for run in ''.join(c if c == sign else ' ' for c in runs).split()[:-1])


@given(st.floats(0.13, 2.0), st.floats(-3.0, -0.85))
def test_a_command_beyond_the_zone_is_unchanged(v, omega):
    assert commands([BodyVelocity(v, omega)] * 3) == [(v, omega)] * 3


def test_a_robot_at_rest_stays_there_until_it_is_twice_as_far_away():
    asked = BodyVelocity(0.1, 0.5)
    pulses, command = in_pulses(Pulses(), asked, TrackingError(0.009, 0.3, -0.019), STANDS, ZONE, DT)
    assert (pulses.rests, command) == (True, (0.0, 0.0))
    pulses, command = in_pulses(pulses, asked, TrackingError(0.019, 0.3, 0.039), STANDS, ZONE, DT)
    assert pulses.rests
    assert not in_pulses(pulses, asked, TrackingError(0.021, 0.0, 0.0), STANDS, ZONE, DT)[0].rests
    # beside a cart that drives there is no rest
    assert not in_pulses(pulses, asked, TrackingError(0.0, 0.0, 0.0), MOVES, ZONE, DT)[0].rests


@pytest.mark.parametrize('rate', [100.0, 20.0])
def test_a_robot_reaches_its_goal_and_rests_there(tmp_path, rate):
    (tmp_path / 'goal.csv').write_text('x,y\n0,0\n1,0\n1.5,0.5\n1.5,1.5\n')
    parameters = {**GOAL, 'reference_cart.path.file': str(tmp_path / 'goal.csv'), '/**.position_rate': rate}
    stuck = mrc.simulate(duration=20.0, parameters={**parameters, 'position_controller.dead_zone.linear': 0.0,
                                                    'position_controller.dead_zone.angular': 0.0})
    assert math.hypot(*stuck.tracking_error[-1, :2]) > 0.1
    run = mrc.simulate(duration=20.0, parameters=parameters)
    assert math.hypot(*run.tracking_error[-1, :2]) < 0.015
    assert abs(run.tracking_error[-1, 2]) < 0.05
    late = run.cmd_vel[run.time > 15.0]
    changes = [sum(a * b < 0.0 for a, b in pairwise(signs))
               for signs in ([value for value in column if value] for column in late.T.tolist())]
    assert max(changes) <= 1
