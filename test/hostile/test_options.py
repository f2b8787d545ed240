"""Nonsense as an option of each command: exit code 2, a few words that name it, nothing on disk."""

import importlib
import os
import random
import signal

import pytest
from commands import command_modules

from hostile.judging import names_one
from hostile.words import NAMES, mangled
from mobile_robot_control import cli

SOUND = {
    'simulate': ['--duration', '0.1'], 'experiment': ['--duration', '0.1', '--output', 'out'],
    'report': ['run.csv', '--output', 'out'], 'tune': ['backstepping', '--seed', '1', '--output', 'out'],
    'study': ['--runs', '1', '--seed', '1', '--output', 'out'], 'benchmark': ['--output', 'out'],
    'plan': ['path.csv', '--output', 'out'], 'excite': ['--box', '1', '1'], 'identify': ['bag', '--output', 'out'],
    'dashboard': [],
}
"""A command line of each command, of files that do not exist."""
NO_NUMBERS = ['nan', 'inf', '-inf', '1e999', 'x', '', '1,5', '0x1', '1/2', '½', '[]', '1e', 'one', '2 m', '1:2', '--']
"""No value of any number of an option."""
NO_NAMES = [name for name in NAMES if name.strip('-\n') and '/' not in name and '.' not in name]
"""No file, parameter, law or number."""
ANY_TEXT = {'-h', '--version', '--output', '--bag', '--report', '--host', '--scheduler', '--path'}
"""Options that take any text, or none."""


class _ParserError(Exception):
    """Brings a parser out of a command."""


def parser_of(main, monkeypatch):
    """Return the parser of a command."""
    def stop(parser, *_):
        raise _ParserError(parser)

    with monkeypatch.context() as patched:
        patched.setattr(cli._CommandParser, 'parse_args', stop)
        with pytest.raises(_ParserError) as caught:
            main([])
    return caught.value.args[0]


def draw_case(draw, command, parser):
    """Draw a command line, and what of it is nonsense."""
    sound, odd = list(SOUND[command]), draw.choice(NO_NAMES)
    options = [one for one in parser._actions if one.option_strings and not ANY_TEXT & {*one.option_strings}]
    one = draw.choice([*options, None, None])
    if one is None:
        # an option that does not exist, or a value of none
        odd = f'--{mangled(draw, draw.choice([each.dest for each in options]))}☹'
        return [*sound, odd, 'x'], [odd, odd.partition('=')[0]]
    name = one.option_strings[-1]
    if one.nargs == 0:
        return [*sound, f'{name}={odd}'], [name]
    if name == '-p':
        odd = draw.choice([odd, f'{odd}:=1', f'plant.{odd}:=1', f'plant.robot.mass:={odd}',
                           f'/**.velocity_rate:={odd}'])
    elif one.metavar in ('X', 'N'):
        odd = draw.choice([*NO_NUMBERS, *(['1.5', '1e3'] if one.metavar == 'N' else [])])
    values = [odd] * (one.nargs if isinstance(one.nargs, int) else 1)
    if name in sound:
        place = sound.index(name)
        del sound[place:place + 1 + len(values)]
    return [*sound, *([f'{name}={odd}'] if len(values) == 1 else [name, *values])], [odd.rpartition(':=')[2], odd, name]


def check(main, arguments, named, capsys):
    """Return what is wrong with the answer of a command to nonsense; '' if nothing is."""
    try:
        code = main(arguments)
    except SystemExit as ended:
        code = ended.code
    except BaseException as error:
        return f'{type(error).__name__}: {error}'
    told = capsys.readouterr().err
    lines = [line for line in told.partition('error: ')[2].splitlines() or told.splitlines() if line]
    faults = [*([f'exit code {code}'] if code != 2 else []), *(['a traceback'] if 'Traceback' in told else []),
              *([f'{len(lines)} lines'] if not 0 < len(lines) <= 4 else []),
              *(['a long line'] if len(max(lines, default='', key=len)) > 1500 else []),
              *([] if names_one(told, named) else [f'none of {named} is named']),
              *(f'{path} is left' for path in os.listdir())]
    return f'{"; ".join(faults)}: {told[-1000:]}' if faults else ''


@pytest.fixture
def main_of(monkeypatch, tmp_path):
    """Return the entry point of a command, in an empty folder and in this process, which stays as it is."""
    # commands with nodes catch signals
    before = {number: signal.getsignal(number) for number in (
        signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGUSR1)}
    monkeypatch.setattr(cli, 'leave_dds', lambda code: code)
    monkeypatch.chdir(tmp_path)
    yield lambda command: importlib.import_module(command_modules()[command]).main
    for number, handler in before.items():
        signal.signal(number, handler)


def play(command, main, parser, count, capsys, seed=1):
    """Return what is wrong with the answers of a command to drawn nonsense."""
    found = []
    for n in range(count):
        arguments, named = draw_case(random.Random(f'{command}/{seed}/{n}'), command, parser)  # noqa: S311 (cases)
        fault = check(main, arguments, named, capsys)
        if fault:
            found.append(f'{command}/{seed}/{n} {[one[:80] for one in arguments]}: {fault}')
    return found


@pytest.mark.parametrize('command', SOUND)
@pytest.mark.parametrize('count', [4, pytest.param(100, marks=pytest.mark.soak)])
def test_nonsense_is_named_with_exit_code_2_and_nothing_is_written(command, count, main_of, monkeypatch, capsys):
    main = main_of(command)
    found = play(command, main, parser_of(main, monkeypatch), count, capsys)
    assert not found, '\n\n'.join(found)


def test_every_command_has_sound_options_here():
    assert [*command_modules()] == [*SOUND]


@pytest.mark.parametrize(('command', 'option'), [
    ('study', '--runs=--'), ('excite', '--robot=nosuch'), ('simulate', f'--robot={"a" * 5000}')])
def test_a_missing_value_an_unused_robot_and_a_long_name_are_refused_in_a_few_words(command, option, main_of, capsys):
    assert check(main_of(command), [*SOUND[command], option], [option.partition('=')[0], 'nosuch', 'aaa'], capsys) == ''
