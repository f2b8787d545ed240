"""`experiment --compare`: one curve and one start for all, a folder for each, one report over them."""

import json
from types import SimpleNamespace

import pytest
from helpers.bag_making import record
from helpers.harness import CONFIG

from mobile_robot_control.experiment import command as experiment
from mobile_robot_control.experiment import runner
from mobile_robot_control.experiment.runner import ExperimentResult
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.report import command as report
from mobile_robot_control.runs.rollout import rollout


@pytest.fixture
def ran(quick, monkeypatch):
    """The parameters of the experiments that were run, by name: in one process instead of over DDS."""
    parameters_by_name = {}
    monkeypatch.delenv('ROS_DOMAIN_ID')

    def run(parameters, output, namespace, composed, patience, stop, bar, supervisor, course, nodes):
        parameters_by_name[output.name] = parameters
        record(output / 'bag', rollout(parameters, parameters.plant.duration))
        stop.requested = output.name == 'stopped'
        return ExperimentResult(*(('node_died', 'no answer') if output.name == 'broken' else ('completed', '')))

    monkeypatch.setattr(runner, 'run_experiment', run)
    monkeypatch.setattr(experiment, 'Stop', lambda: SimpleNamespace(requested=False))
    return parameters_by_name


def _compare(output, *files, extra=()):
    return experiment.main(['--duration', '0.1', '--output', str(output), '--no-report', '--compare', *map(str, files),
                            *extra])


def test_every_run_has_the_curve_and_the_start_of_the_first(ran, tmp_path):
    other = tmp_path / 'other.yaml'
    other.write_text((CONFIG / 'fuzzy.yaml').read_text().replace('curve: trifolium', 'rotation: 1.0'))
    assert 'rotation: 1.0' in other.read_text()
    assert _compare(tmp_path / 'out', CONFIG / 'hybrid_backstepping.yaml', other,
                    extra=['-p', 'plant.initial_pose:=[0.8, 0.1, 0.2]']) == 0
    hybrid, fuzzy = ran['hybrid_backstepping'], ran['other']
    assert hybrid.reference_cart.curve == fuzzy.reference_cart.curve
    assert fuzzy.reference_cart.curve.placement.rotation == 0.0
    assert hybrid.plant.initial_pose == fuzzy.plant.initial_pose == (0.8, 0.1, 0.2)
    assert [parameters.position_controller.control.controller_type for parameters in ran.values()] == [
        'hybrid_backstepping', 'fuzzy']
    assert set(json.loads((tmp_path / 'out' / 'report.json').read_text())) == {'hybrid_backstepping', 'other'}
    assert 'rotation: 0.0' in (tmp_path / 'out' / 'other' / 'parameters.yaml').read_text()


@pytest.mark.parametrize(('name', 'others', 'reason'), [
    ('broken', ['fuzzy_1', 'fuzzy_2'], 'broken: node_died: no answer'), ('stopped', [], 'stopped: interrupted')])
def test_a_failed_run_is_reported_and_a_stop_request_ends_the_comparison(ran, tmp_path, capsys, name, others, reason):
    ran.clear()
    file, out = tmp_path / f'{name}.yaml', tmp_path / f'{name}_out'
    file.write_text((CONFIG / 'fuzzy.yaml').read_text())
    # files of the same name get numbered folders
    assert _compare(out, file, CONFIG / 'fuzzy.yaml', CONFIG / 'fuzzy.yaml') == 1
    assert list(ran) == [name, *others]
    assert (out / 'report.html').is_file()
    assert reason in capsys.readouterr().err


def test_no_run_starts_when_one_file_or_folder_is_refused_and_all_stay_as_they_were(ran, tmp_path, capsys):
    (tmp_path / 'out' / 'backstepping' / 'bag').mkdir(parents=True)
    for files, told in (([CONFIG / 'fuzzy.yaml', tmp_path / 'nowhere.yaml'], 'nowhere.yaml'),
                        ([CONFIG / 'fuzzy.yaml'] * 7, '6 at the most'),
                        ([CONFIG / 'fuzzy.yaml', CONFIG / 'backstepping.yaml'], 'holds an experiment already')):
        assert _compare(tmp_path / 'out', *files) == 2
        assert told in capsys.readouterr().err
    assert not ran
    assert [path.name for path in (tmp_path / 'out').iterdir()] == ['backstepping']


def test_a_refused_run_leaves_its_folder_as_it_was_and_those_of_the_runs_before_it(ran, tmp_path, monkeypatch, capsys):
    run = runner.run_experiment

    def refuse_the_second(parameters, output, *arguments, **options):
        if ran:
            (output / 'bag').mkdir()
            raise ParameterError(['another node publishes'])
        return run(parameters, output, *arguments, **options)

    monkeypatch.setattr(runner, 'run_experiment', refuse_the_second)
    out = tmp_path / 'out'
    (out / 'hybrid_backstepping').mkdir(parents=True)
    (out / 'hybrid_backstepping' / 'notes.txt').write_text('mine')
    files = [CONFIG / name for name in ('fuzzy.yaml', 'hybrid_backstepping.yaml', 'backstepping.yaml')]
    assert _compare(out, *files) == 2
    assert capsys.readouterr().err.endswith('experiment: another node publishes\n')
    assert (out / 'fuzzy' / 'metrics.json').is_file()
    assert [path.name for path in (out / 'hybrid_backstepping').iterdir()] == ['notes.txt']
    assert not (out / 'backstepping').exists()


def test_a_namespace_that_ros_does_not_take_is_bad_usage(tmp_path, capsys):
    for namespace in ('', 'a/b', '//', '/x/', '/1x'):
        for command, arguments in ((experiment, ['--duration', '1']), (report, ['run'])):
            with pytest.raises(SystemExit) as ended:
                command.main([*arguments, '--output', str(tmp_path / 'out'), '--namespace', namespace])
            assert ended.value.code == 2
            assert f"'{namespace}' is no namespace of ROS" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
