"""Laws and curves from outside the package: registered, replaced, refused with their origin, looked for when needed."""

import itertools
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated, NamedTuple

import pytest

from mobile_robot_control import BodyVelocity, Curve, CurvePoint, Field, Law, jitable
from mobile_robot_control.control.laws import BUILT_IN, LAWS, PositionControl, select
from mobile_robot_control.parameters.declaration import ParameterError, build, declarations
from mobile_robot_control.parameters.plugins import load_plugins, load_sources, plugin_environment, plugin_sources
from mobile_robot_control.parameters.registry import PluginError
from mobile_robot_control.reference.cart import CurveParameters
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

PLUGINS = Path(__file__).parents[2] / 'plugins'
LAW = '''
from typing import Annotated, NamedTuple
from mobile_robot_control import BodyVelocity, Field, Law
class Gains(NamedTuple):
    gain: Annotated[float, Field('', 'larger is faster', above=0.0, live=True)] = 1.0
def step(state, observation, gains, dt):
    return state, BodyVelocity(gains.gain, 0.0)
LAW = Law('mine', step, Gains)
'''


class Gains(NamedTuple):
    gain: Annotated[float, Field('1/s', 'larger is faster', above=0.0, live=True, search=(0.0, 2.0))] = 1.0


@jitable
def step(state, observation, gains, dt):
    return state, BodyVelocity(gains.gain, 0.0)


MINE = Law('mine', step, Gains)
VALUES = {'controller_type': 'mine', 'mine.gain': 1.0}


def written(folder, text, name='mine.py'):
    (folder / name).write_text(text)
    return str(folder / name)


def straight(s):
    return CurvePoint(s, s, 1.0, 1.0, 0.0, 0.0)


def test_a_registered_law_has_its_parameters_among_the_others(registered):
    before = set(declarations(PositionControl))
    registered(MINE)
    assert set(declarations(PositionControl)) == before | {'mine.gain'}
    control = build(PositionControl, VALUES | {'mine.gain': 0.5})
    assert select(control, 0.01) == (MINE, Gains(0.5))
    assert load([], ['position_controller.mine.gain:=0.5'])['position_controller'] == {'mine.gain': 0.5}
    # and the others keep theirs
    assert control.backstepping == PositionControl().backstepping


def test_two_laws_of_one_name_from_different_files_are_refused_with_both_origins(registered, tmp_path):
    registered(MINE._replace(horizon=1))
    # the same file again replaces its law
    registered(MINE)
    file = written(tmp_path, LAW)
    with pytest.raises(PluginError, match=r'is defined in .* already; rename one of them') as refused:
        load_plugins({'law': [file]})
    assert file in str(refused.value)
    assert os.path.realpath(__file__) in str(refused.value)
    assert LAWS['mine'] is MINE
    for name in ('mine', 'backstepping'):
        LAWS.remove(name)
    assert ('mine' in LAWS, 'backstepping' in LAWS) == (False, True)
    with pytest.raises(ParameterError, match=r"unknown parameter 'mine.gain'"):
        load([], ['position_controller.mine.gain:=0.5'])


@pytest.mark.parametrize(('registry', 'record', 'words'), [
    (LAWS, MINE._replace(name='velocity'), "the law 'velocity' has the name of a parameter"),
    (LAWS, MINE._replace(name='limits'), "the law 'limits' has the name of a parameter"),
    (LAWS, MINE._replace(name=''), 'is no ROS name'),
    (LAWS, MINE._replace(step=lambda error, dt: None),
     "the step of 'mine' is no function step(state, observation, gains"),
    (CURVES, Curve('Bad name', straight), 'is no ROS name'),
    (CURVES, Curve('bent', lambda s: (s, s)), 'return CurvePoint'),
    (CURVES, Curve('circle', straight), 'in mobile_robot_control already'),
    (CURVES, 3, 'CURVE is of type int'),
])
def test_an_incomplete_law_or_curve_is_refused_in_words(registry, record, words):
    before = set(registry)
    with pytest.raises((PluginError, AttributeError)) as refused:
        registry.register(record)
    assert words in str(refused.value)
    assert set(registry) == before


def gains_of(annotation, default='1.0'):
    return LAW.replace("Annotated[float, Field('', 'larger is faster', above=0.0, live=True)] = 1.0",
                       f'{annotation}{f" = {default}" if default else ""}')


def field(*arguments):
    return gains_of(f"Annotated[float, Field('', 'larger'{''.join(f', {argument}' for argument in arguments)})]")


@pytest.mark.parametrize(('text', 'words'), [
    ('import nowhere', 'cannot be imported (ModuleNotFoundError'),
    ('import sys\nsys.exit(3)', 'cannot be imported (SystemExit'),
    ('def (', 'cannot be imported (SyntaxError'),
    ('', 'has no LAW; end it with LAW = Law(name, step, gains)'),
    (gains_of("Annotated[float, Field('', 'larger', above=0.0)]", ''), 'each with a default'),
    (gains_of('float'), 'annotated with Field'),
    (field(), "'mine': its gain 'gain' has neither bounds nor a range"),
    (field('above=0.0', 'search=(2.0, 1.0)'), 'it must hold that 0.0 <= low < high <= inf'),
    (field('minimum=0.0', 'maximum=1.0', 'search=(-1.0, 2.0)'), 'it must hold that 0.0 <= low < high <= 1.0'),
    (field('above=1.0'), 'its default gain = 1.0 is not allowed'),
])
def test_a_file_that_cannot_be_loaded_is_named_with_its_reason(tmp_path, text, words):
    file = written(tmp_path, text)
    with pytest.raises(PluginError) as refused:
        load_plugins({'law': [file]})
    assert file in str(refused.value)
    assert words in str(refused.value)
    assert 'mine' not in LAWS


def test_a_file_that_cannot_be_read_and_a_folder_without_one_are_refused(tmp_path):
    for file in ('nowhere.py', str(tmp_path)):
        with pytest.raises(PluginError, match=r'cannot be read|has no Python file'):
            load_plugins({'law': [file]})


@pytest.mark.parametrize(('point', 'words'), [
    (lambda s: straight(s)._replace(ddy=0.0 / (s < 1.0)), 'fails at s = 1.07992 rad (ZeroDivisionError'),
    (lambda s: straight(s)._replace(y=math.nan if s > 3.0 else s), 'is not finite at s = 3.04342 rad'),
])
def test_a_curve_that_fails_somewhere_is_refused_with_the_place(registered, point, words):
    registered(Curve('bent', point))
    with pytest.raises(ParameterError) as refused:
        build(CurveParameters, {'curve': 'bent'})
    assert words in str(refused.value)


def test_a_parameter_value_that_names_a_file_or_a_module_imports_nothing(tmp_path, monkeypatch):
    (tmp_path / 'mine.py').write_text(f'open({str(tmp_path / "ran")!r}, "w").close()\n{LAW}')
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    for name, value in itertools.product(('position_controller.controller_type', 'reference_cart.curve'),
                                         (tmp_path / 'mine.py', 'mine', 'mine.LAW', 'mine:LAW')):
        with pytest.raises(ParameterError, match='is not allowed'):
            configure(load([], [f'{name}:={value}']))
    assert not (tmp_path / 'ran').exists()


def test_files_are_handed_on_to_other_processes(registered):
    load_plugins({'law': [str(PLUGINS / 'kanayama.py')], 'curve': [str(PLUGINS / 'ellipse.py')]})
    assert plugin_environment() == {'MOBILE_ROBOT_CONTROL_LAWS': str(PLUGINS / 'kanayama.py'),
                                    'MOBILE_ROBOT_CONTROL_CURVES': str(PLUGINS / 'ellipse.py')}
    sources = plugin_sources()
    law, curve = LAWS['my_kanayama'], CURVES['ellipse']
    load_sources(sources)
    assert LAWS['my_kanayama'] is law  # it has this content already
    LAWS.remove('my_kanayama')
    CURVES.remove('ellipse')
    load_sources(sources)
    assert LAWS['my_kanayama'].gains()._asdict() == law.gains()._asdict()
    assert CURVES['ellipse'](0.5) == curve(0.5)


def test_the_environment_names_files_and_what_fails_harms_nothing(tmp_path):
    broken = written(tmp_path, 'import nowhere', 'broken.py')
    code = ('from mobile_robot_control.control.laws import LAWS; print(list(LAWS));'
            'from mobile_robot_control.settings.configure import configure;'
            "configure({'position_controller': {'controller_type': 'broken'}})")
    done = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=False,
        env=os.environ | {'MOBILE_ROBOT_CONTROL_LAWS': os.pathsep.join([broken, written(tmp_path, LAW)])})
    assert done.stdout.strip() == str([*(law.name for law in BUILT_IN), 'mine'])
    assert f'not loaded: {broken}: cannot be imported (ModuleNotFoundError' in done.stderr
    # the reason is in the refusal, too, of what asks for it
    assert "controller_type = 'broken' is not allowed" in done.stderr
    assert f'; not loaded: {broken}' in done.stderr


def test_a_checksum_changes_with_the_source(tmp_path, registered):
    load_plugins({'law': [written(tmp_path, LAW)]})
    before = LAWS.checksum('mine')
    load_plugins({'law': [written(tmp_path, LAW.replace('gains.gain, 0.0', 'gains.gain, 1.0'))]})
    assert LAWS.checksum('mine') != before


def test_gains_that_cannot_be_prepared_are_refused(registered):
    registered(MINE._replace(prepare=lambda gains, dt: 1.0 / (gains.gain - 1.0)))
    with pytest.raises(ParameterError, match=r"the law 'mine' cannot prepare its gains .*ZeroDivisionError"):
        configure({'position_controller': VALUES})
    made = configure({'position_controller': VALUES | {'mine.gain': 3.0}})
    assert select(made.position_controller.control, 0.01)[1] == 0.5
