"""Reports name the error that they mean, and take the true one wherever it is known: from tables and from bags."""

import io
import math

import pytest
from helpers.bag_making import record
from helpers.harness import numbers_in
from helpers.measuring import configuration, measured

from mobile_robot_control.figures.drawing import draw
from mobile_robot_control.loop.metric_table import INDICES
from mobile_robot_control.quantities import WheelTorque
from mobile_robot_control.report import command as report
from mobile_robot_control.runs.csv_table import CSV_COLUMNS, Rows, write_csv
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.settings.files import configuration_text

pytestmark = pytest.mark.usefixtures('quick')

DURATION = 0.5
NOISE = {'noise.pose': [0.01, 0.02, 0.01], 'noise.velocity': 0.05}
NOISY = configuration(plant={**NOISE, 'duration': DURATION})
AHEAD = configuration(plant={'duration': DURATION},
                      position_controller={'compensate_latency': True, 'odom_latency': 0.05})
NAMES = ('rms_position_error', 'max_position_error', 'rms_heading_error', 'measured_rms_position_error', 'objective',
         *INDICES)


def reported(folder, run):
    assert report.main([f'run={run}', '--output', str(folder)]) == 0
    return numbers_in(folder / 'report.json')['run'], (folder / 'report.html').read_text()


@pytest.mark.parametrize(('name', 'parameters'), [('noise', NOISY), ('carried forward', AHEAD)])
def test_a_bag_has_the_true_errors_of_its_rollout_and_alone_those_that_are_called_measured(tmp_path, name, parameters):
    experiment = tmp_path / name
    record(experiment / 'bag', rollout(parameters, DURATION))
    (experiment / 'parameters.yaml').write_text(configuration_text(parameters))
    metrics, page = reported(tmp_path / f'out {name}', experiment)
    expected, _ = measured(parameters, DURATION)
    assert (metrics['error'], metrics['problems']) == ('true', [])
    for key in NAMES:
        assert metrics[key] == pytest.approx(expected[key], rel=1e-9)
    assert metrics['final_pose'] == pytest.approx(expected['final_pose'], abs=1e-9)
    assert metrics['measured_rms_position_error'] != metrics['rms_position_error']
    assert 'position error by odometry, RMS' in page
    assert 'True error: ' in page
    if parameters is AHEAD:
        (experiment / 'parameters.yaml').unlink()
        metrics, page = reported(tmp_path / 'alone', experiment / 'bag')
        assert metrics['error'] == 'measured'
        assert metrics['rms_position_error'] == pytest.approx(expected['measured_rms_position_error'], rel=1e-9)
        assert 'Measured error (odometry): ' in page


def test_torques_that_are_not_known_are_empty_in_a_table_and_read_back():
    unknown = WheelTorque(math.nan, math.nan)
    samples = [sample._replace(applied=unknown, torque=unknown) for sample in rollout(configuration(), 0.02)]
    file = io.StringIO()
    assert list(write_csv(samples, file)) == samples
    head, *lines = file.getvalue().splitlines()
    for line in lines:
        empty = [name for name, cell in zip(head.split(','), line.split(','), strict=True) if not cell]
        assert empty == [name for name in CSV_COLUMNS if 'effort' in name]
    file.seek(0)
    rows = Rows(file)
    found = list(rows)
    assert not rows.left_out
    assert [sample.wheels for sample in found] == [sample.wheels for sample in samples]
    assert all(math.isnan(value) for sample in found for value in (*sample.applied, *sample.torque))
    # a single torque that is missing is a damaged row
    cells = lines[3].split(',')
    cells[CSV_COLUMNS.index('wheel_torques.effort.wheel_left_joint')] = '1.0'
    rows = Rows(io.StringIO('\n'.join([head, ','.join(cells)])))
    assert not list(rows)
    assert sum(rows.left_out.values()) == 1


def test_the_true_path_is_drawn_beside_that_of_odometry():
    noisy, exact = (Run('run', collect(rollout(parameters, DURATION)), (), {}, None)
                    for parameters in (NOISY, configuration()))
    kinds = {figure.name: figure for figure in RUN_FIGURES}
    shown, plain = ({name: draw(kinds[name].of_runs([run])) for name in ('path', 'errors', 'distance')}
                    for run in (noisy, exact))
    labels = [line.get_label() for line in shown['path'].axes[0].lines]
    assert labels[:3] == ['reference', 'robot, true', 'robot, by odometry']
    assert 'robot, by odometry' not in [line.get_label() for line in plain['path'].axes[0].lines]
    for name in ('errors', 'distance'):
        assert [text.get_text() for text in shown[name].axes[0].get_legend().get_texts()] == ['true', 'measured']
        assert plain[name].axes[0].get_legend() is None
        assert kinds[name].of_runs([noisy]).caption != kinds[name].caption
        assert kinds[name].of_runs([exact]).caption == kinds[name].caption
