"""What the commands have in common on the command line."""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from mobile_robot_control.cli.outputs import explain, is_full
from mobile_robot_control.configuration import Configuration, configure
from mobile_robot_control.parameter_files import load, write
from mobile_robot_control.parameters import ParameterError, flatten


def parser(name: str, description: str) -> argparse.ArgumentParser:
    """
    Make a parser with the options that all commands share.

    Parameters
    ----------
    name, description : str
        Of the command.

    Returns
    -------
    ArgumentParser
        With ``--params-file`` and ``-p``.

    """
    made = argparse.ArgumentParser(prog=name, description=description)
    made.add_argument('--params-file', action='append', default=[], metavar='FILE', dest='params_files',
                      help='ROS 2 parameter file, as the nodes take it; again and again: later wins')
    made.add_argument('-p', action='append', default=[], metavar='NODE.PARAMETER:=VALUE', dest='overrides',
                      help="one parameter, such as plant.max_wheel_torque:=3.0 or '/**.position_rate:=50.0'")
    return made


def positive(text: str) -> float:
    """
    Read a positive number of seconds.

    Parameters
    ----------
    text : str
        As typed.

    Returns
    -------
    float
        [s].

    Raises
    ------
    ArgumentTypeError
        If it is not a positive, finite number.

    """
    try:
        value = float(text)
    except ValueError:
        value = float('nan')
    if not 0.0 < value < float('inf'):
        raise argparse.ArgumentTypeError(f"'{text}' is not a positive number of seconds; write one such as 16.0")
    return value


def configuration(options: argparse.Namespace, namespace: str = '/', extra: Sequence[str] = ()) -> Configuration:
    """
    Make the configuration that the shared options ask for.

    Parameters
    ----------
    options : Namespace
        Parsed by :func:`parser`'s parser.
    namespace : str
        In which the nodes run.
    extra : sequence of str
        Further overrides, which win.

    Returns
    -------
    Configuration
        Checked.

    Raises
    ------
    ParameterError
        Naming every violation.

    """
    return configure(load(options.params_files, [*options.overrides, *extra], namespace))


def written(parameters: Configuration) -> str:
    """
    Give a configuration as the text of a parameter file.

    Parameters
    ----------
    parameters : Configuration
        Checked.

    Returns
    -------
    str
        YAML that gives the same numbers to the last bit.

    """
    return write({node: flatten(part) for node, part in parameters._asdict().items()})


def distinct(names: Sequence[str]) -> list[str]:
    """
    Number names that occur more than once.

    Parameters
    ----------
    names : sequence of str
        Of runs.

    Returns
    -------
    list of str
        All different.

    Examples
    --------
    >>> distinct(['fuzzy', 'hybrid', 'fuzzy'])
    ['fuzzy_1', 'hybrid', 'fuzzy_2']

    """
    return [f'{name}_{names[:n + 1].count(name)}' if names.count(name) > 1 else name for n, name in enumerate(names)]


def command(name: str, run: Callable[[], int]) -> int:
    """
    Run a command and turn what the user can mend into a message and an exit code.

    Parameters
    ----------
    name : str
        Of the command.
    run : callable
        Does it; returns the exit code.

    Returns
    -------
    int
        0 done, 1 the run failed, 2 bad usage or parameters.

    """
    try:
        return run()
    except ParameterError as error:
        for violation in error.violations:
            print(f'{name}: {violation}', file=sys.stderr)
        return 2
    except OSError as error:
        print(f'{name}: {explain(error)}', file=sys.stderr)
        return 1 if is_full(error) else 2
    except ModuleNotFoundError as error:
        print(f'{name}: the Python module {error.name} is missing; install it with rosdep or pip', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f'{name}: interrupted', file=sys.stderr)
        return 1


def writable_file(path: str) -> Path:
    """
    Check that a file can be written, before anything long begins.

    Parameters
    ----------
    path : str
        As typed.

    Returns
    -------
    Path
        Its folder exists now.

    Raises
    ------
    OSError
        If it cannot be written.

    """
    file = Path(path)
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open('a'):
        return file
