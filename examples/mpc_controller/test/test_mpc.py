"""The law solves its quadratic program, keeps its limits, and satisfies what is asked of a law."""

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
import yaml
from mpc_controller.error_model import error_model
from mpc_controller.mpc import LAW, MpcGains, prepare, step

from mobile_robot_control import BodyVelocity, Observation, Pose, Reference, TrackingError
from mobile_robot_control.testing import check_law

DT = 0.01


def _command(error, reference=(0.5, 0.2), **gains):
    observation = Observation(TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*reference)),
                              BodyVelocity(0.0, 0.0))
    return step(LAW.start, observation, prepare(MpcGains(**gains), DT), DT)[1]


def test_it_is_a_law():
    with warnings.catch_warnings():
        # that numba does not compile it is known
        warnings.simplefilter('ignore')
        # over DDS it is driven by the tests of the repository
        assert 'gains' in check_law(LAW, over_dds=False).passed


@pytest.mark.parametrize(('v_r', 'omega_r'), [(0.5, 0.8), (0.3, 1e-3), (1.0, 1e-9), (0.0, 0.0), (0.4, -20.0)])
def test_the_model_is_the_solution_over_a_stage(v_r, omega_r):
    """Many small steps of Heun's method give it too."""
    period, count = 0.2, 4000
    flow = np.array([[0.0, omega_r, 0.0], [-omega_r, 0.0, v_r], [0.0, 0.0, 0.0]])
    push = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
    small = period / count
    state, forced = np.eye(3), np.zeros((3, 2))
    for _ in range(count):
        state = state + small * flow @ (state + 0.5 * small * flow @ state)
        slope = flow @ forced + push
        forced = forced + small * (slope + 0.5 * small * flow @ slope)
    a, b = error_model(v_r, omega_r, period)
    assert a == pytest.approx(state, abs=1e-6)
    assert b == pytest.approx(forced, abs=1e-6)


def test_on_the_cart_it_commands_the_velocity_of_the_cart():
    assert _command((0.0, 0.0, 0.0)) == pytest.approx(BodyVelocity(0.5, 0.2), abs=1e-9)


def test_one_stage_by_hand():
    """Straight ahead, N = 1: u1 = -q T e1 / (q T² + r), and the error in the heading alike."""
    command = _command((0.1, 0.0, 0.0), (0.5, 0.0), stages=1, period=0.1, longitudinal=40.0, linear=1.0)
    assert command.linear == pytest.approx(0.5 + 40.0 * 0.1 * 0.1 / (40.0 * 0.01 + 1.0), abs=1e-7)
    command = _command((0.0, 0.0, 0.1), (0.0, 0.0), stages=1, period=0.1, heading=5.0, angular=0.5)
    assert command.angular == pytest.approx(5.0 * 0.1 * 0.1 / (5.0 * 0.01 + 0.5), abs=1e-7)


def test_the_command_keeps_its_limits_and_the_rest_of_the_plan_makes_up_for_them():
    free = _command((0.5, 0.3, 0.2), max_linear=100.0, max_angular=100.0)
    assert free.linear > 1.0
    bound = _command((0.5, 0.3, 0.2), max_linear=0.8, max_angular=100.0)
    assert bound.linear == pytest.approx(0.8, abs=1e-9)
    # a limit is not a saturation behind the law: what v cannot do changes omega
    assert abs(bound.angular - free.angular) > 1e-3


def test_where_the_solver_has_no_answer_it_drives_as_the_reference_does():
    assert _command((1e300, 0.0, math.pi / 3.0)) == pytest.approx(BodyVelocity(0.25, 0.2))


def test_the_parameter_file_has_the_defaults():
    file = Path(__file__).parents[1] / 'config' / 'mpc.yaml'
    parameters = yaml.safe_load(file.read_text(encoding='utf-8'))['/**/position_controller']['ros__parameters']
    assert MpcGains(**parameters['mpc']) == MpcGains()
