"""`tune` in Python gives the numbers of the command for the same seed."""

import csv
import functools

import pytest
from helpers.measuring import selecting

import mobile_robot_control as mrc
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop import batch
from mobile_robot_control.search import command as tune
from mobile_robot_control.settings.files import load

# a loop so short that plain Python runs it in a few milliseconds
SMALL = {'/**.velocity_rate': 100.0, '/**.position_rate': 50.0, 'reference_cart.period': 0.5,
         'reference_cart.scale': 0.05}
SHORT = [word for name, value in SMALL.items() for word in ('-p', f'{name}:={value}')]


@pytest.fixture(scope='module', autouse=True)
def uncompiled():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batch, 'COMPILES', False)
        yield


@pytest.fixture(scope='module')
def found(uncompiled):
    return mrc.tune('backstepping', seed=3, parameters=SMALL, generations=3, population=6, workers=1,
                    bounds={'k1': (0, 2), 'k2': (0, 2)}, keep=['ti1'], laps=0.8, start=[(-0.01, 0.0, 0.0)])


def test_a_search_finds_what_the_command_finds(found, tmp_path):
    file = tmp_path / 'gains.yaml'
    assert tune.main(['backstepping', '--seed', '3', *SHORT, '--generations', '3', '--population', '6',
                      '--workers', '1', '--bounds', 'k1=0:2', '--bounds', 'k2=0:2', '--keep', 'ti1', '--laps', '0.8',
                      '--start=-0.01,0,0', '--output', str(file)]) == 0
    written = mrc.configure(load([file]))
    assert found.configuration.velocity_controller == written.velocity_controller
    assert found.configuration.position_controller == written.position_controller
    assert f'objective {found.objective!r}' in file.read_text()
    with file.with_suffix('.csv').open() as table:
        assert [float(row['best']) for row in csv.DictReader(table)] == [one.best for one in found.history]


def test_what_a_search_has_found_is_simulated_saved_and_reported(found, tmp_path):
    assert found.parameters['velocity_controller.gains.k1'] == found.configuration.velocity_controller.gains.k1
    run = mrc.simulate(duration=0.4, parameters=SMALL | found.parameters)
    found.save(tmp_path / 'saved.yaml')
    assert mrc.simulate(tmp_path / 'saved.yaml', duration=0.4).metrics == run.metrics
    assert (tmp_path / 'saved.yaml').read_text().startswith('# backstepping gains found by mobile_robot_control ')
    page = found.report(tmp_path / 'found' / 'gains.yaml')
    assert page.file == tmp_path / 'found' / 'gains.html'
    assert 'Before and after' in page.html
    assert mrc.configure(load([tmp_path / 'found' / 'gains.yaml'])) == found.configuration


def test_what_a_search_has_found_prints_itself_in_a_line(found):
    found = found._replace(objective=1.25, parameters={
        'position_controller.controller_type': 'backstepping', 'position_controller.backstepping.p': 0.5,
        'velocity_controller.gains.k1': 0.25})
    assert repr(found) == '<Tuned backstepping: objective 1.25 after 9 generations, p = 0.5, gains.k1 = 0.25>'


@pytest.mark.parametrize('law', LAWS)
def test_a_first_look_finds_better_gains_than_the_configured_ones_for_every_law(law):
    found = mrc.tune(law, seed=3, parameters=SMALL | selecting(law), generations=2, population=10, workers=1, laps=0.4)
    assert found.better.searched < found.better.configured
    default, control = mrc.configure({}).position_controller.control, found.configuration.position_controller.control
    assert control.controller_type == law
    group, = {name.split('.')[1] for name in found.parameters if name.count('.') > 1 and 'gains' not in name}
    assert group == ('backstepping' if law == 'hybrid_backstepping' else law)
    assert getattr(control, group) != getattr(default, group)


@pytest.mark.parametrize(('options', 'refusal'), [
    ({'generations': 0}, 'generations = 0 is not allowed; it must be at least 1'),
    ({'bounds': {'k9': (0, 1)}}, "no gene 'k9'"), ({'generation': 3}, "unknown option 'generation'; did"),
    ({'output': 'gains.yaml'}, 'output: nothing is written to files from Python'),
    ({'bounds': {'k1': 5}}, r"bounds = \('k1', 5\): .* or a pair \(low, high\)"),
    ({'bounds': {'k1': '05'}}, r"bounds = \('k1', '05'\): .* or a pair"), ({'laps': 1e9}, 'would take too long'),
    ({'algorithm': 'luck'}, "algorithm = 'luck' is not allowed; it must be one of nelder_mead"),
    ({'runs': 0}, 'runs = 0 is not allowed; it must be at least 1'),
    ({'runs': 1, 'longest_delay': 99}, 'longest_delay = 99 is not allowed; it must be at least 0, at most 8'),
    ({'runs': 1, 'overwrite': True}, 'overwrite: nothing is written to files from Python'),
    ({'runs': 1, 'compare': ['nowhere.yaml']}, 'nowhere.yaml: cannot be read'),
    ({'runs': 1, 'laps': 1e9}, 'would take too long'),
    ({'runs': 1, 'compare': {'odd': {'plant.noise.seed': -1}}}, 'noise.seed = -1'),
])
def test_what_the_commands_refuse_is_refused(options, refusal):
    call = mrc.study if 'runs' in options else functools.partial(mrc.tune, 'backstepping', parameters=SMALL)
    with pytest.raises(mrc.ParameterError, match=refusal):
        call(seed=1, **options)


def test_a_search_without_a_result_is_an_error():
    with pytest.raises(RuntimeError, match='no individual could be scored'):
        mrc.tune('backstepping', seed=1, generations=1, population=5, workers=1, keep='ti1',
                 parameters=SMALL | {'plant.disturbance.step': [1e9, 1e9]})
