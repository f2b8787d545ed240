"""The numbers of a replay: few points, gaps where nothing is known."""

import base64
import json

import numpy as np
import pytest
from helpers.measuring import configuration

from mobile_robot_control.figures.figure import Line
from mobile_robot_control.figures.palette import LINES
from mobile_robot_control.pages.replay_data import SHAPES, largest_since, replay_data
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import Messages, collect
from mobile_robot_control.runs.series import Series

PARAMETERS = configuration(plant={'duration': 1.0})


@pytest.fixture(scope='module')
def series():
    return collect(rollout(PARAMETERS, 1.0))


def numbers(packed):
    return np.frombuffer(base64.b64decode(packed), '<f4')


def long_run(count):
    """A run of so many messages with one peak each of torque and error, and one point far out."""
    messages = Messages()
    for n in range(count):
        peak = n == count // 3 + 1
        messages.add('odom', n * 10**7, (9.0 if n == count // 2 + 1 else 0.0, 0.0, 0.0, 0.0, 0.0))
        messages.add('tracking_error', n * 10**7, (5.0 if peak else 0.1, 0.0, 0.0))
        messages.add('joint_states', n * 10**7, (0.1 * n, 0.1 * n, 1.0, 1.0, -7.0 if peak else 0.2, 0.1))
    return Run('long', Series(messages.last_run().signals), (), {}, None)


def run(name='run', duration=0.5, **nodes):
    parameters = configuration(**nodes)
    return Run(name, collect(rollout(parameters, duration)), (), {}, parameters)


def test_a_short_run_keeps_every_pose_and_its_numbers(series):
    run = Run('run', series, (), {}, PARAMETERS)
    data = replay_data([run])
    assert (data['start'], data['end'], data['trail']) == (0.0, 1.0, 16.0)
    assert numbers(data['runs'][0]['columns']['time']).size == 101
    np.testing.assert_allclose(numbers(data['runs'][0]['columns']['x']), series.line('odom', 'x').value, rtol=1e-6)
    robot = PARAMETERS.plant.shared.robot
    assert data['runs'][0]['wheelSeparation'] == robot.wheel_separation
    peaks = [np.abs(series.torque(wheel).value).max() for wheel in ('right', 'left')]
    assert data['runs'][0]['limit'] == pytest.approx(max(peaks))


def test_a_long_run_is_thinned_and_keeps_its_extremes():
    data = replay_data([long_run(40_000)])
    assert numbers(data['runs'][0]['columns']['time']).size < 12_010
    assert numbers(data['runs'][0]['columns']['error']).max() == 5.0
    assert numbers(data['runs'][0]['columns']['rightTorque']).min() == -7.0
    assert numbers(data['runs'][0]['columns']['x']).max() == 9.0
    assert len(json.dumps(data)) < 1_000_000
    assert len(set(SHAPES)) == len(LINES)
    # six share the room of two
    assert len(json.dumps(replay_data([long_run(15_000)] * 6))) < 2_000_000


def test_the_largest_value_since_the_time_before_stays_and_silence_is_not_filled():
    line = Line(np.array([0.0, 0.1, 0.2, 0.3, 0.4]), np.array([1.0, -9.0, 2.0, np.nan, 3.0]))
    found = largest_since(line, np.array([-1.0, 0.0, 0.25, 0.45, 0.5, 2.0]))
    np.testing.assert_array_equal(found, [np.nan, 1.0, -9.0, 3.0, 3.0, np.nan])


def test_what_no_run_has_is_left_out(series):
    signals = series.signals
    alone = Series({'odom': signals['odom']})
    data = replay_data([Run('run', alone, (), {}, None)])
    assert set(data['runs'][0]['columns']) == {'time', 'x', 'y', 'heading'}
    assert data['runs'][0]['wheelSeparation'] is None
    assert data['errorScale'] == 0.0
    nothing = Run('run', Series({}), (), {}, None)
    assert replay_data([nothing]) is None
    assert replay_data([nothing, Run('run', alone, (), {}, None)])['end'] == 1.0


def test_a_number_that_no_float_of_a_page_can_hold_is_not_known():
    messages = Messages()
    for n, x in enumerate([0.0, 1.0, 1e300, float('nan')]):
        messages.add('odom', n * 10**7, (x, 0.0, 0.0, 0.0, 0.0))
    data = replay_data([Run('run', Series(messages.last_run().signals), (), {}, None)])
    np.testing.assert_array_equal(numbers(data['runs'][0]['columns']['x']), [0.0, 1.0, np.nan, np.nan])


def test_the_path_is_a_whole_lap_where_the_cart_followed_the_curve_and_its_trace_elsewhere(series):
    def path(parameters):
        return numbers(replay_data([Run('run', series, (), {}, parameters)])['path']['x'])

    recorded = series.line('reference', 'x').value
    assert np.nanmin(path(PARAMETERS)) < -0.4 < recorded.min()
    other = configuration(reference_cart={'curve': 'circle'})
    np.testing.assert_allclose(path(other)[:-1], recorded, rtol=1e-6)
    np.testing.assert_allclose(path(None)[:-1], recorded, rtol=1e-6)
