"""How every command is made and run: its parser from requests, its exit codes, and errors as messages."""

import argparse
import contextlib
import errno
import inspect
import shlex
import sys
from collections.abc import Callable, Collection, Sequence
from typing import Any, NoReturn, TypeVar

from mobile_robot_control.parameters.declaration import ParameterError, nearest
from mobile_robot_control.parameters.plugins import load_plugins
from mobile_robot_control.parameters.requests import Option, assemble, options_of
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.system.files import explain, is_disk_full
from mobile_robot_control.system.process import discard_output, flush_output, prepare_streams
from mobile_robot_control.system.supervisor import leave_dds
from mobile_robot_control.system.texts import missing, told
from mobile_robot_control.version import __version__

Request = TypeVar('Request')

_KEEP_GOING = '--keep-going'
"""Of `benchmark`: other commands refuse the option after the files are loaded."""
EXIT_CODES = """Exit codes:
  0  done
  1  failed: the motion diverged, the law failed, a node died, Ctrl-C, a full disk
  2  bad usage or parameters: one line per violation, with the remedy; nothing was started"""
"""Of a command whose docstring has none of its own."""


def _add_plugin_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group('laws and curves of your own')
    group.add_argument('--law', action='append', default=[], metavar='FILE.py', dest='law_files',
                       help='Python file with a position law, or a folder of them; may be repeated')
    group.add_argument('--velocity-law', action='append', default=[], metavar='FILE.py', dest='velocity_law_files',
                       help='Python file with a velocity law VELOCITY_LAW, or a folder of them; may be repeated')
    group.add_argument('--curve', action='append', default=[], metavar='FILE.py', dest='curve_files',
                       help='Python file with a curve CURVE; may be repeated')


class _CommandParser(argparse.ArgumentParser):
    """Loads the files of laws and curves before other options may name what these define."""

    drives = False
    """Whether the command drives the configured law, and so the one law of its ``--law``."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        words = sys.argv[1:] if args is None else list(args)
        plugins = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
        loaded: dict[str, tuple[str, ...]] = {}
        _add_plugin_options(plugins)
        try:
            early, _ = plugins.parse_known_args(args)
            loaded = load_plugins({'law': early.law_files, 'velocity law': early.velocity_law_files,
                                   'curve': early.curve_files}, _KEEP_GOING in words)
        except argparse.ArgumentError:
            pass  # the whole parser says so in its own words
        except ParameterError as error:
            self.exit(2, ''.join(f'{self.prog}: {told(violation)}\n' for violation in error.violations))
        for word in words[:words.index('--')] if '--' in words else words:
            name, _, value = word.partition('=')
            # argparse names what is missing first, and takes a word with a space for a value
            if name.startswith('--') and ' ' not in word and name not in self._option_string_actions:
                self.error(f"unknown option '{name}'; {nearest(name, self._option_string_actions)}")
            # argparse drops it, and takes the option for one without a value
            if name.startswith('--') and value == '--':
                self.error(f"argument {name}: '--' is no value; write one")
        options, rest = super().parse_known_args(args, namespace)
        options.command_line = shlex.join(['mrc', self.prog, *words])
        # a search names its position law, and drives the velocity law
        options.own_laws = loaded if self.drives else {'velocity law': loaded.get('velocity law', ())}
        return options, rest

    def format_usage(self) -> str:
        return self._of_mrc(super().format_usage())

    def format_help(self) -> str:
        return self._of_mrc(super().format_help())

    def _of_mrc(self, text: str) -> str:
        return text.replace(f'usage: {self.prog}', f'usage: mrc {self.prog}', 1)

    def error(self, message: str) -> NoReturn:
        # the values that it quotes may contain anything
        super().error(told(message))


def make_parser(
    name: str, documentation: str | None, *requests: type, positional: Collection[str] = (), drives: bool = False
) -> argparse.ArgumentParser:
    """
    Make a command's parser: what all commands take, and an option for each field of its requests.

    Parameters
    ----------
    name : str
        Of the command.
    documentation : str or None
        Its module's docstring: the first paragraph describes it after a colon, the others end the help; None where
        Python drops docstrings.
    *requests : type
        NamedTuples whose fields are declared with `Field`; read them from the options with `request_of`.
    positional : collection of str
        Fields that are arguments without a name.
    drives : bool
        Whether the command drives the configured law; then the one law of ``--law`` is selected if no other is.

    """
    # an abbreviated --law would be read after the options that need its law
    first, _, notes = inspect.cleandoc(documentation or '').partition('\n\n')
    parser = _CommandParser(
        prog=name, description=first.partition(': ')[2], allow_abbrev=False,
        epilog='\n\n'.join(filter(None, [notes, '' if 'Exit codes:' in notes else EXIT_CODES])),
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.drives = drives
    parser.add_argument('--version', action='version', version=f'{name} {__version__}')
    parser.add_argument('--robot', metavar='NAME|FILE', help='name of a robot of this package, or its parameter file; '
                        'the other parameter files and -p win over it')
    parser.add_argument('--params-file', action='append', default=[], metavar='FILE', dest='params_files',
                        help='ROS 2 parameter file, as for a node; may be repeated, later files win')
    parser.add_argument('-p', action='append', default=[], metavar='NODE.PARAMETER:=VALUE', dest='overrides',
                        help="one parameter, such as plant.max_wheel_torque:=3.0, or '/**.position_rate:=50.0' for all "
                        'nodes; it wins over the files; may be repeated')
    for request in requests:
        for option in options_of(request).values():
            _add_option(parser, option, option.name in positional)
    _add_plugin_options(parser)
    return parser


def _add_option(parser: argparse.ArgumentParser, option: Option, positional: bool) -> None:
    """Declare an option for a field of a request; what is not given is left to the request."""
    flag = f'--{option.name.replace("_", "-")}'
    if option.kind is bool:
        parser.add_argument(f'--no-{flag[2:]}' if option.default else flag, dest=option.name, default=argparse.SUPPRESS,
                            action='store_false' if option.default else 'store_true', help=_help(option))
        return
    words: dict[str, Any] = {'type': _element(option), 'metavar': _form(option), 'help': _help(option)}
    if option.is_several and option.reader and option.reader.again:
        words['action'] = 'append'
    elif option.is_several:
        words['nargs'] = option.field.length or '+'
        if not (positional or option.field.length):
            words['action'] = 'extend'
    if positional:
        parser.add_argument(option.name, **words)
    else:
        parser.add_argument(flag, dest=option.name, required=option.is_required, default=argparse.SUPPRESS, **words)


def _form(option: Option) -> str:
    """Return what stands for a value in the help."""
    if option.reader:
        return option.reader.form
    return 'N' if option.kind is int else option.name.upper() if option.kind is str else 'X'


def _help(option: Option) -> str:
    """Return the description of an option, with its unit, its bounds and its default."""
    default, reader = option.default, option.reader
    shown = ('' if default in (None, ()) or option.kind is bool else ' '.join(map(str, default)) if option.is_several
             else default)
    more = [*([f'for example {reader.example}'] if reader and reader.example else []), *filter(None, [option.bounds]),
            *(['may be repeated'] if reader and reader.again else []), *([f'default {shown}'] if shown != '' else [])]
    return (option.meaning + (f' ({"; ".join(more)})' if more else '')).replace('%', '%%')


def _element(option: Option) -> Callable[[str], Any]:
    """Make a function that reads a value, or an element of it, for an option's ``type``."""
    def read(word: str) -> Any:
        value: Any = word
        if option.reader is None and option.kind in (int, float):
            with contextlib.suppress(ValueError):
                value = option.kind(word)
        try:
            return option.element(value)
        except ParameterError as error:
            raise argparse.ArgumentTypeError('; '.join(error.violations)) from None

    return read


def request_of(request: type[Request], options: argparse.Namespace) -> Request:
    """Return the request that the options of `make_parser` make."""
    given = {name: getattr(options, name) for name in options_of(request) if hasattr(options, name)}
    values = {name: tuple(value) if isinstance(value, list) else value for name, value in given.items()}
    return assemble(request, {**values, 'sources': sources_of(options)})


def sources_of(options: argparse.Namespace) -> ParameterSources:
    """Return where the options that all commands take find the loop's parameters."""
    return ParameterSources(options.robot, tuple(options.params_files), tuple(options.overrides),
                            options.own_laws.get('law', ()), options.own_laws.get('velocity law', ()))


def _tell_of_law(command: str, options: argparse.Namespace) -> None:
    """Say in a line if -p selects a law without the other gains of its shipped set."""
    if not any('controller_type' in one for one in getattr(options, 'overrides', ())):
        return
    from mobile_robot_control.settings.law_sets import law_note  # noqa: PLC0415 (reads the parameters once more)

    with contextlib.suppress(ParameterError):  # the command tells
        note = law_note(sources_of(options))
        if note:
            print(f'{command}: {note}', file=sys.stderr)


def make_main(
    make_parser: Callable[[], argparse.ArgumentParser], run: Callable[[argparse.Namespace], int]
) -> Callable[..., int]:
    """
    Make the entry point of a command.

    Parameters
    ----------
    make_parser : callable
        Makes the parser, whose name stands before each error text.
    run : callable
        Does what the options ask for; returns the exit code.

    Returns
    -------
    callable
        Takes a command line or nothing and returns the exit code: 0 done, 1 the run failed, 2 bad usage or parameters.
        An error that the user can mend becomes one line for each violation.

    """
    def main(arguments: Sequence[str] | None = None) -> int:
        prepare_streams()
        parser = make_parser()
        name = parser.prog.rpartition('.')[2]
        try:
            options = parser.parse_args(arguments)
            _tell_of_law(name, options)
            code = run(options)
            flush_output()
            return code
        except ParameterError as error:
            for violation in error.violations:
                print(f'{name}: {told(violation)}', file=sys.stderr)
            return 2
        except BrokenPipeError:
            discard_output()
            print(f'{name}: nothing reads the standard output any more; what is written to files is complete',
                  file=sys.stderr)
            return 1
        except OSError as error:
            discard_output()
            print(f'{name}: {told(explain(error))}', file=sys.stderr)
            # EIO: a terminal that was closed meanwhile
            return 1 if is_disk_full(error) or error.errno == errno.EIO else 2
        except ModuleNotFoundError as error:
            print(f'{name}: {missing(error.name, name)}', file=sys.stderr)
            return 2
        except KeyboardInterrupt:
            print(f'{name}: interrupted', file=sys.stderr)
            return 1
        finally:
            discard_output()

    return main


def make_dds_main(
    make_parser: Callable[[], argparse.ArgumentParser], run: Callable[[argparse.Namespace], int]
) -> Callable[..., int]:
    """Make the entry point of a command with nodes, which also ends where to leave DDS hangs."""
    main = make_main(make_parser, run)
    return lambda arguments=None: leave_dds(main(arguments))
