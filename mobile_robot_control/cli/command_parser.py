"""The parser of a command: the options that all commands take, laws and curves from files first."""

import argparse
import sys
from collections.abc import Callable, Collection, Iterator
from typing import Any, NoReturn

from mobile_robot_control import __version__
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.values import nearest
from mobile_robot_control.plugins import load_plugins
from mobile_robot_control.texts import printable


def _add_plugin_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group('laws and curves of your own')
    group.add_argument('--law', action='append', default=[], metavar='FILE.py', dest='law_files',
                       help='Python file with a position law LAW; again and again')
    group.add_argument('--curve', action='append', default=[], metavar='FILE.py', dest='curve_files',
                       help='Python file with a curve CURVE; again and again')


class _CommandParser(argparse.ArgumentParser):
    """Loads the files of ``--law`` and ``--curve`` before other options may name what these define."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        plugins = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
        _add_plugin_options(plugins)
        try:
            early, _ = plugins.parse_known_args(args)
            load_plugins(early.law_files, early.curve_files)
        except argparse.ArgumentError:
            pass  # the whole parser says so in its own words
        except ParameterError as error:
            self.exit(2, ''.join(f'{self.prog}: {printable(violation)}\n' for violation in error.violations))
        given = sys.argv[1:] if args is None else list(args)
        for word in given[:given.index('--')] if '--' in given else given:
            name = word.partition('=')[0]
            # argparse names what is missing first, and takes a word with a space for a value
            if name.startswith('--') and ' ' not in word and name not in self._option_string_actions:
                self.error(f"unknown option '{name}'; {nearest(name, self._option_string_actions)}")
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        # the values that it quotes may contain anything
        super().error(printable(message))


def make_parser(name: str, documentation: str | None) -> argparse.ArgumentParser:
    """
    Make a command's parser with what all take: ``--robot``, ``--params-file``, ``-p``, ``--law`` and ``--curve``.

    Its description is what follows the colon in its module's docstring, which is None where Python drops docstrings.
    """
    # an abbreviated --law would be read after the options that need its law
    made = _CommandParser(prog=name, description=(documentation or '').partition(': ')[2], allow_abbrev=False)
    made.add_argument('--version', action='version', version=f'{name} {__version__}')
    made.add_argument('--robot', metavar='NAME|FILE', help='robot of this package, or parameter file of a robot; read '
                      'before the other parameter files')
    made.add_argument('--params-file', action='append', default=[], metavar='FILE', dest='params_files',
                      help='ROS 2 parameter file, as the nodes take it; again and again: later wins')
    made.add_argument('-p', action='append', default=[], metavar='NODE.PARAMETER:=VALUE', dest='overrides',
                      help="one parameter, such as plant.max_wheel_torque:=3.0 or '/**.position_rate:=50.0'")
    _add_plugin_options(made)
    return made


class Lazy(Collection[str]):
    """
    Choices of an option that are known only once ``--law`` and ``--curve`` are read.

    Parameters
    ----------
    names : callable
        Returns the present choices, in the order to name them.

    """

    def __init__(self, names: Callable[[], Collection[str]]) -> None:
        self._names = names

    def __contains__(self, name: object) -> bool:
        return name in self._names()

    def __iter__(self) -> Iterator[str]:
        return iter(self._names())

    def __len__(self) -> int:
        return len(list(self._names()))
