"""The shipped set of a law: what belongs to it, which gains are the user's own, and what a command without it says."""

import pytest

from mobile_robot_control.control.laws import BUILT_IN
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.runs import command as simulation
from mobile_robot_control.settings.configure import ParameterSources, configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.law_sets import (
    differing,
    groups_set_by_user,
    law_note,
    node_note,
    set_for,
    shipped,
    shipped_set,
)

LAW = 'position_controller.controller_type'


def _present(*overrides, files=()):
    """Return the parameters by node, as a page has them."""
    return {node: {name: list(value) if isinstance(value, tuple) else value for name, value in flatten(part).items()}
            for node, part in configure(load(files, overrides))._asdict().items()}


@pytest.mark.parametrize('law', BUILT_IN, ids=lambda law: law.name)
def test_a_set_has_the_law_all_its_gains_and_the_velocity_gains_of_its_file(law):
    found = shipped_set(law.name)
    assert found.given == f'config/{law.name}.yaml'
    groups = {name.partition('.')[0] for name in found.values['position_controller']} - {'controller_type'}
    assert groups == set(law.groups or (law.name,))
    assert len(found.values['velocity_controller']) == 4
    assert shipped(law.name).get('/**.reference_horizon', 0) == law.horizon
    assert differing(found, _present(files=[found.file])) == {}
    # what is changed by the set is what the file changes
    present = _present()
    for node, values in differing(found, present).items():
        present[node] |= values
    assert differing(found, present) == {}


@pytest.mark.parametrize('override', ['/**.velocity_rate:=1000.0', '/**.robot.mass:=5.0', 'plant.drive:=velocity'])
def test_another_robot_or_rate_has_no_shipped_set(override):
    assert set_for('fuzzy', _present()) is not None
    assert set_for('fuzzy', _present(override)) is None
    assert set_for('fuzzy', {'position_controller': _present()['position_controller']}) is None


def test_gains_that_are_neither_defaults_nor_of_a_set_are_the_users():
    assert groups_set_by_user(_present(files=[shipped_set('fuzzy').file])) == set()
    # one gain of another set does not make it that set
    found = groups_set_by_user(_present('position_controller.fuzzy.a:=0.0523369', 'velocity_controller.gains.k1:=0.2'))
    assert found == {('position_controller', 'fuzzy'), ('velocity_controller', 'gains')}


@pytest.mark.parametrize(('overrides', 'words'), [
    ([f'{LAW}:=fuzzy'], 'controller_type = fuzzy changes the law alone: position_controller.fuzzy and '
     'velocity_controller.gains differ from config/fuzzy.yaml; take them with --params-file config/fuzzy.yaml'),
    ([(LAW, 'hybrid_backstepping'), ('velocity_controller.gains.k1', 0.4)], 'position_controller.backstepping and'),
    ([f'{LAW}:=kanayama'], ''),
    (['plant.max_wheel_torque:=1.0'], ''),
    ([f'{LAW}:=fuzzy', '/**.position_rate:=50.0'], ''),
])
def test_a_law_selected_without_its_set_is_told_in_a_line(overrides, words):
    note = law_note(ParameterSources(overrides=tuple(overrides)))
    assert words in note
    assert bool(words) == bool(note)


@pytest.mark.parametrize(('overrides', 'files', 'words'), [
    ([], [], 'controller_type = fuzzy changes the law alone: position_controller.fuzzy differs from config/fuzzy.yaml; '
     'choose the law on the live page'),
    (['position_controller.fuzzy.a:=1.0'], ['fuzzy.yaml'], 'position_controller.fuzzy differs from'),
    # of the velocity gains the node knows nothing
    (['velocity_controller.gains.k1:=0.2'], ['fuzzy.yaml'], ''),
    (['/**.robot.mass:=5.0'], [], ''),
    ([], ['wall_clock.yaml'], ''),
])
def test_a_node_tells_of_its_own_gains_alone(overrides, files, words):
    folder = shipped_set('fuzzy').file.parent
    configuration = configure(load([folder / name for name in files], [*overrides, f'{LAW}:=fuzzy']))
    note = node_note('fuzzy', configuration.position_controller)
    assert words in note
    assert bool(words) == bool(note)


def test_a_command_tells_it_beside_its_result_which_stays_the_same(capsys):
    arguments = ['--duration', '0.1', '--json']
    assert simulation.main([*arguments, '-p', f'{LAW}:=fuzzy']) == 0
    alone = capsys.readouterr()
    assert alone.err.startswith('simulate: controller_type = fuzzy changes the law alone')
    assert alone.err.count('\n') == 1
    file = str(shipped_set('fuzzy').file)
    assert simulation.main([*arguments, '--params-file', file, '-p', f'{LAW}:=fuzzy']) == 0
    shipped = capsys.readouterr()
    assert shipped.err == ''
    assert shipped.out != alone.out
