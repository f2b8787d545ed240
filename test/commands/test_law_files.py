"""The commands with a law and a curve from files of their own: searched, resumed, refused."""

import re
from pathlib import Path

import pytest

from mobile_robot_control.runs import command as simulate
from mobile_robot_control.search import command as tune
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

pytestmark = pytest.mark.usefixtures('plain', 'registered')

PLUGINS = Path(__file__).parents[1] / 'plugins'
LAW = ['--law', str(PLUGINS / 'kanayama.py')]
SMALL = ['-p', '/**.velocity_rate:=100.0', '-p', '/**.position_rate:=50.0', '-p', 'reference_cart.period:=0.5',
         '-p', 'reference_cart.scale:=0.05', '--workers', '1']
BARE = ['my_kanayama', '--seed', '3', *SMALL]
SEARCH = [*BARE, '--population', '7', '--bounds', 'gains.k1=0:2', '--bounds', 'k2=0:2']


def test_a_law_from_a_file_is_searched_and_the_other_laws_gains_stay(tmp_path):
    output = tmp_path / 'found.yaml'
    # so poor that a short search finds better ones
    poor = ['-p', 'position_controller.my_kanayama.a:=1.0e+6']
    assert tune.main([*SEARCH, *LAW, *poor, '--generations', '2', '--output', str(output)]) == 0
    found, default = configure(load([output])), configure({}).position_controller.control
    control = found.position_controller.control
    assert control.controller_type == 'my_kanayama'
    assert control.my_kanayama.a < 1e6
    # b1 has no range to search; k1 means the velocity gain, whose law has one of that name
    assert control.my_kanayama.b1 == 1.0
    assert 0.0 < found.velocity_controller.gains.k1 <= 2.0
    for law in ('backstepping', 'hybrid_backstepping', 'fuzzy'):
        assert getattr(control, law) == getattr(default, law)
    # gains to keep stay as they are configured
    keep = ['--keep', 'my_kanayama.k1', 'p', '-p', 'position_controller.my_kanayama.p:=3.0', '--overwrite']
    assert tune.main([*SEARCH, *LAW, *poor, *keep, '--generations', '1', '--output', str(output)]) == 0
    gains = configure(load([output])).position_controller.control.my_kanayama
    assert (gains.p, gains.k1) == (3.0, 12.0)
    assert gains.a < 1e6


@pytest.mark.parametrize(('arguments', 'words'), [
    (['--bounds', 'k1=0:2'], "'k1' may be position_controller.my_kanayama.k1 or velocity_controller.gains.k1"),
    (['--keep', 'k3'], "keep: there is no gene 'k3' here"),
    (['--keep', 'a', 'p', 'my_kanayama.k1', 'gains.k1', 'ti1', 'k2', 'ti2'], "'my_kanayama' leaves nothing to search"),
])
def test_names_that_are_not_clear_are_refused(tmp_path, capsys, arguments, words):
    assert tune.main([*BARE, *LAW, '--output', str(tmp_path / 'found.yaml'), *arguments]) == 2
    assert words in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_resume_refuses_a_journal_whose_law_has_changed(tmp_path, capsys):
    law, output, journal = (tmp_path / name for name in ('law.py', 'found.yaml', 'found.yaml.journal'))
    text = (PLUGINS / 'kanayama.py').read_text()
    law.write_text(text)
    search = [*SEARCH, '--law', str(law), '--output', str(output), '--algorithm', 'differential_evolution',
              '--generations']
    # ended by its time, with a journal
    assert tune.main([*search, '50', '--time-limit', '1e-9']) == 1
    before = journal.read_bytes()
    law.write_text(text.replace('math.sin(e3)', 'e3'))
    capsys.readouterr()
    assert tune.main([*search, '50', '--resume']) == 2
    assert "was begun with source of the law 'my_kanayama' = " in capsys.readouterr().err
    assert journal.read_bytes() == before
    law.write_text(text)
    assert tune.main([*search, '1', '--resume']) == 0


@pytest.mark.parametrize(('end', 'arguments', 'driven', 'words'), [
    ("LAW = Law('named', step, Gains)", [], 'named', "the law 'named' of --law is selected"),
    ("register(Law('registered', step, Gains))", [], 'registered', "the law 'registered' of --law is selected"),
    ("LAW = register(Law('both', step, Gains))", [], 'both', "the law 'both' of --law is selected"),
    ("LAW = Law('unused', step, Gains)", ['-p', 'position_controller.controller_type:=lqr'], 'lqr', ''),
    ("register(Law('one', step, Gains)); register(Law('two', step, Gains))", [], 'backstepping',
     "the law 'backstepping' is selected, and none of one, two; to choose one, add "
     '-p position_controller.controller_type:=two'),
])
def test_a_file_with_one_law_selects_it_unless_another_is_named(tmp_path, capsys, end, arguments, driven, words):
    file = tmp_path / 'law.py'
    file.write_text(f"""
from typing import NamedTuple
from mobile_robot_control import BodyVelocity, Law, register
class Gains(NamedTuple):
    pass
def step(state, observation, gains, dt):
    return state, observation.reference.velocity
{end}
""")
    assert simulate.main(['--law', str(file), '--duration', '0.1', *arguments]) == 0
    printed = capsys.readouterr()
    assert printed.out.startswith(f'On the trifolium, {driven} completed')
    assert printed.err == (f'{words}\n' if words else '')


def test_a_law_that_is_not_loaded_is_refused_with_both_ways_to_load_it(capsys):
    for word in ('controller_type:=my_kanayama', 'my_kanayama.kx:=1.0'):
        assert simulate.main(['--duration', '1', '-p', f'position_controller.{word}']) == 2
        assert re.search('with --law, or register it in Python', capsys.readouterr().err)
    with pytest.raises(SystemExit, match='2'):
        tune.main([*BARE, '--output', 'found.yaml'])
    assert re.search('with --law, or register it in Python', capsys.readouterr().err)


@pytest.mark.parametrize(('option', 'text', 'words'), [
    ('--law', 'import nowhere', "cannot be imported (ModuleNotFoundError: No module named 'nowhere' in {file}, "
     'line 1); mend it, or leave it out'),
    ('--law', 'x = 1', 'has no LAW; end it with LAW = Law(name, step, gains)'),
    ('--curve', 'x = 1', 'has no CURVE; end it with CURVE = Curve(name, point)'),
])
def test_a_bad_plug_in_file_is_bad_usage(tmp_path, capsys, option, text, words):
    file = tmp_path / 'bad.py'
    file.write_text(text)
    with pytest.raises(SystemExit) as ended:
        simulate.main([option, str(file), '--duration', '1'])
    assert ended.value.code == 2
    assert capsys.readouterr().err == f'simulate: {file}: {words.format(file=file)}\n'
