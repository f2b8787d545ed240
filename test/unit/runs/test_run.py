"""Runs in Python: the numbers of the commands as arrays on one time base, their figures and their tables."""

import json
import sys
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from helpers.bag_making import record
from helpers.harness import numbers_in

import mobile_robot_control as mrc
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.loop.metric_table import INDICES
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.quantities import WheelVelocity
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.report import command as report
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.runs.run import COLUMNS
from mobile_robot_control.topics import LOOP_TOPICS

FUZZY = str(Path(__file__).parents[3] / 'config' / 'fuzzy.yaml')
START = {'plant.initial_pose': [0.9, 0.1, 1.2]}
HEADINGS = ('pose', 'reference', 'odometry')


class Gains(NamedTuple):
    """A law has at least one."""

    gain: Annotated[float, mrc.Field('1/s', 'larger does nothing', above=0.0)] = 1.0


@pytest.fixture(scope='module')
def run():
    """Half a second, from beside the path."""
    return mrc.simulate(FUZZY, duration=0.5, parameters=START)


@pytest.fixture
def table(tmp_path, capsys):
    """The same run by the command: its CSV, and what it printed."""
    file = tmp_path / 'table.csv'
    assert simulate.main(['--duration', '0.5', '--params-file', FUZZY, '-p', 'plant.initial_pose:=[0.9, 0.1, 1.2]',
                          '--output', str(file), '--json']) == 0
    return file, json.loads(capsys.readouterr().out)


def test_metrics_and_arrays_are_those_that_the_command_writes(run, table):
    loaded = mrc.load(table[0])
    assert run.metrics == table[1]
    assert np.array_equal(run.time, np.arange(251) * 2_000_000 / 1e9)
    assert np.array_equal(run.time, loaded.time)
    for name, columns in COLUMNS.items():
        assert getattr(run, name).shape == (251, len(columns))
        # a table has quaternions in place of headings, from which rows between position ticks are made
        tolerance = 1e-14 if name in (*HEADINGS, 'tracking_error', 'velocity', 'reference_velocity') else 0.0
        assert np.allclose(getattr(run, name), getattr(loaded, name), rtol=0.0, atol=tolerance), name
    final = loaded.metrics.pop('final_pose')
    assert final == pytest.approx(run.metrics['final_pose'], rel=0.0, abs=1e-15)
    assert loaded.metrics == {name: value for name, value in run.metrics.items() if name != 'final_pose'}
    assert (loaded.parameters, loaded.name) == (run.parameters, 'table')
    assert not loaded.problems


def test_a_bag_gives_the_same_arrays_also_with_other_names_of_topics(run, tmp_path):
    record(tmp_path / 'bag', list(mrc.rollout(run.parameters, 0.5)), '/base/')
    loaded = mrc.load(tmp_path / 'bag', topics={name: f'/base/{name}' for name in LOOP_TOPICS})
    assert loaded.name == tmp_path.name
    for name in COLUMNS:
        assert np.allclose(getattr(run, name), getattr(loaded, name), rtol=0.0, atol=1e-14), name


def test_what_a_base_does_not_tell_is_nan_and_not_drawn():
    base = mrc.simulate(duration=0.2, parameters={'plant.drive': 'velocity'})
    assert np.isnan(base.wheel_torque).all()
    with pytest.raises(mrc.ParameterError, match="figure = 'torque': nothing of it is known of backstepping"):
        base.plot('torque')


def test_every_row_has_the_values_of_its_own_time():
    run = mrc.simulate(duration=4.0)
    curve = run.parameters.reference_cart.curve
    exact = [reference_at(mrc.CURVES[curve.curve], time, curve.placement) for time in run.time]
    assert np.abs(run.reference - [one.pose for one in exact]).max() < 1e-8
    assert np.abs(run.reference_velocity - [one.velocity for one in exact]).max() < 3e-4
    errors = [tracking_error(mrc.Pose(*cart), mrc.Pose(*robot))
              for cart, robot in zip(run.reference, run.pose, strict=True)]
    assert np.abs(run.tracking_error - errors).max() < 1e-12
    # the wheels are those of every step: velocity, and the way that it makes
    body = np.array([body_velocity(WheelVelocity(*wheels), run.parameters.plant.shared.robot)
                     for wheels in run.wheel_velocity])
    assert np.abs(run.velocity - body).max() < 1e-3
    rates = np.column_stack([body[:, 0] * np.cos(run.pose[:, 2]), body[:, 0] * np.sin(run.pose[:, 2]), body[:, 1]])
    moved = np.remainder(np.diff(run.pose, axis=0) + np.pi, 2.0 * np.pi) - np.pi
    assert np.abs(moved - 0.001 * (rates[1:] + rates[:-1])).max() < 1e-6


def test_where_odometry_is_not_exact_pose_and_error_are_true_and_what_was_measured_is_beside_them():
    noisy = mrc.simulate(duration=0.5, parameters={'plant.noise.pose': (0.05, 0.05, 0.02)})
    assert noisy.metrics['error'] == 'true'
    assert np.abs(noisy.odometry - noisy.pose).max() > 0.01
    ended = noisy.tracking_error[:-1:5]
    assert np.sqrt(np.mean(ended[:, 0]**2 + ended[:, 1]**2)) == pytest.approx(noisy.metrics['rms_position_error'])
    ended = noisy.measured_error[:-1]
    assert np.sqrt(np.mean(ended[:, 0]**2 + ended[:, 1]**2)) == pytest.approx(
        noisy.metrics['measured_rms_position_error'])


def test_a_law_and_a_curve_of_a_notebook_have_their_names(registered):
    def step(state, observation, gains, dt):
        return state, mrc.BodyVelocity(0.25, 0.0)

    registered(mrc.Law('straight', step, Gains))
    registered(mrc.Curve('straight_on', lambda s: mrc.CurvePoint(s, 0.0, 1.0, 0.0, 0.0, 0.0), closed=False))
    driven = mrc.simulate(duration=0.2, parameters={'position_controller.controller_type': 'straight',
                                                    'reference_cart.curve': 'straight_on'})
    assert driven.name == 'straight'
    assert set(driven.cmd_vel[:, 0]) == {0.25}
    assert not driven.reference[:, 1].any()


def test_a_run_that_diverges_or_whose_law_fails_ends_there_with_a_warning_that_gives_the_remedy(registered):
    def step(state, observation, gains, dt):
        raise ValueError('no such place')

    registered(mrc.Law('lost', step, Gains))
    for parameters, told, outcome in (
            ({'plant.disturbance.step': [1e9, 1e9]}, 'the motion diverged at t = 0', 'diverged'),
            ({'position_controller.controller_type': 'lost'}, "'lost' failed .*no such place", 'law_failed')):
        with pytest.warns(RuntimeWarning, match=told) as caught:
            ended = mrc.simulate(duration=0.5, parameters=parameters)
        assert caught[0].filename == __file__
        assert ended.metrics['outcome'] == outcome

def test_a_run_is_drawn_alone_and_with_others_and_prints_itself_in_a_line(run):
    assert repr(run).startswith('<Run fuzzy, shipped gains: 251 samples, to t = 0.5 s, completed, RMS position error')
    assert '\n' not in repr(run._replace(name='a\nb'))
    assert run.plot()._repr_png_().startswith(b'\x89PNG')
    drawn = run.plot('errors', run._replace(name='$other'))
    assert [text.get_text() for text in drawn.axes[0].get_legend().get_texts()][-2:] == ['fuzzy', r'\$other']


def test_a_notebook_shows_metrics_as_a_table_and_files_have_them_as_before(run):
    shown = run.metrics._repr_html_()
    assert f'<td>rms_position_error</td><td>{run.metrics["rms_position_error"]:.4g}</td><td>m</td>' in shown
    assert '<td>peak_wheel_torque</td><td>right ' in shown
    assert shown.count('<tr>') == len(run.metrics) + 1
    assert json.loads(json.dumps(run.metrics)) == dict(run.metrics)


@pytest.mark.parametrize(('arguments', 'refusal'), [
    (('pth',), "figure = 'pth': there is no such figure; did you mean 'path'"),
    (('path', *range(6)), '7 runs are more'), (('errors', 'path'), "'path': a figure is drawn of runs alone"),
    ((None,), 'figure is a run; name the figure first'),
])
def test_what_cannot_be_drawn_is_refused(run, arguments, refusal):
    with pytest.raises(mrc.ParameterError, match=refusal):
        run.plot(*(argument or run for argument in arguments))


@pytest.mark.parametrize('parameters', [
    START, {'plant.noise.pose': [0.05, 0.05, 0.02]}, {'plant.drive': 'velocity', 'plant.base.lag': [0.1, 0.1]}])
def test_a_saved_run_has_the_bytes_of_the_command_and_is_read_back(tmp_path, parameters):
    hidden = mrc.simulate(duration=0.2, parameters=parameters)
    hidden.save(tmp_path / 'saved.csv')
    loaded = mrc.load(tmp_path / 'saved.csv')
    assert loaded.metrics['error'] == 'true'
    for name in ('rms_position_error', 'max_position_error', 'measured_rms_position_error', 'objective', *INDICES):
        assert (loaded.metrics[name] or 0.0) == pytest.approx(hidden.metrics[name] or 0.0, rel=1e-9), name
    for name in COLUMNS:
        assert np.allclose(getattr(hidden, name), getattr(loaded, name), rtol=0.0, atol=1e-14, equal_nan=True), name
    file = tmp_path / 'command.csv'
    options = [word for name, value in parameters.items() for word in ('-p', f'{name}:={value}')]
    assert simulate.main(['--duration', '0.2', *options, '--output', str(file)]) == 0
    for ending in ('.csv', '.parameters.yaml'):
        assert file.with_suffix(ending).read_bytes() == (tmp_path / f'saved{ending}').read_bytes()
    assert numbers_in(tmp_path / 'saved.metrics.json') == numbers_in(tmp_path / 'command.metrics.json')


def test_a_run_is_saved_as_a_table_alone_and_replaces_the_parameters_of_another(run, tmp_path):
    with pytest.raises(mrc.ParameterError, match=r'name a file that ends in \.csv'):
        run.save(tmp_path / 'saved.mcap')
    assert not list(tmp_path.iterdir())
    for one in (run, run._replace(parameters=None)):
        one.save(tmp_path / 'saved.csv')
    assert not (tmp_path / 'saved.parameters.yaml').exists()
    assert mrc.load(tmp_path / 'saved.csv').parameters is None


def test_pandas_takes_a_run(run):
    pandas = pytest.importorskip('pandas')
    table = run.to_dataframe()
    assert isinstance(table, pandas.DataFrame)
    assert (list(table.index), table.index.name) == (list(run.time), 'time')
    assert list(table.columns)[:3] == ['pose.x', 'pose.y', 'pose.heading']
    assert len(table.columns) == sum(map(len, COLUMNS.values()))
    assert np.array_equal(table['cmd_vel.angular'], run.cmd_vel[:, 1])


def test_without_pandas_an_error_says_what_to_do(run, monkeypatch):
    monkeypatch.setitem(sys.modules, 'pandas', None)
    with pytest.raises(ModuleNotFoundError, match=r'needs pandas, .* or take columns') as raised:
        run.to_dataframe()
    assert raised.value.name == 'pandas'


@pytest.mark.parametrize(('keywords', 'options'), [
    ({'parameters': {'plant.noise.seed': -1, '/**.velocity_rate': 0.5, 'plant.max_wheel_torqe': 3.0}},
     ['-p', 'plant.noise.seed:=-1', '-p', '/**.velocity_rate:=0.5', '-p', 'plant.max_wheel_torqe:=3.0']),
    ({'parameters': {'reference_cart.curve': 'sqare'}}, ['-p', "reference_cart.curve:='sqare'"]),
    ({'robot': 'nowhere.yaml'}, ['--robot', 'nowhere.yaml']), ({'robot': 'chaptr'}, ['--robot', 'chaptr']),
])
def test_errors_are_those_of_the_command(capsys, keywords, options):
    assert simulate.main(['--duration', '0.5', *options]) == 2
    printed = [line.removeprefix('simulate: ') for line in capsys.readouterr().err.splitlines()]
    with pytest.raises(mrc.ParameterError) as raised:
        mrc.simulate(duration=0.5, **keywords)
    assert list(raised.value.violations) == printed


@pytest.mark.parametrize(('keywords', 'refusal'), [
    ({'duration': -1.0}, r'duration = -1\.0 is not allowed; it must be above 0\.0 s'),
    ({'duration': 1e11}, 'would take too long'), ({'duration': 1e-9}, 'is too short for a step'),
    ({'parameters': ['config/fuzzy.yaml']}, r'parameters = .*: write them by NODE\.PARAMETER'),
])
def test_a_duration_without_a_step_or_an_end_and_parameters_without_names_are_refused(keywords, refusal):
    with pytest.raises(mrc.ParameterError, match=refusal):
        mrc.simulate(**{'duration': 0.1} | keywords)


def test_what_is_no_run_is_refused_in_the_words_of_the_report(capsys, tmp_path):
    assert report.main(['nowhere', '--output', str(tmp_path)]) == 2
    with pytest.raises(mrc.ParameterError) as raised:
        mrc.load('nowhere')
    assert capsys.readouterr().err == f'report: {raised.value}\n'
