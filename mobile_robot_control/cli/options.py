"""Options that commands share, and how every command is run."""

import argparse
import contextlib
import itertools
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from mobile_robot_control.files import check_regular, explain, is_disk_full
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.configuration import at_cart_start, configure
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.parameters.files import Values, load, parameter_file_text
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.parameters.robot_files import robot_file
from mobile_robot_control.streams import discard_output, flush_output, prepare_streams
from mobile_robot_control.texts import printable


def _float(text: str) -> float:
    """Read a number; nan where it is none."""
    try:
        return float(text)
    except ValueError:
        return float('nan')


def ros_path(text: str) -> str:
    """Read a path that nodes are given, which ROS takes in UTF-8 alone."""
    try:
        os.path.abspath(text).encode()
    except UnicodeEncodeError:
        raise argparse.ArgumentTypeError(f"'{text}' is not UTF-8, as ROS needs it; name another folder") from None
    return text


def positive(text: str) -> float:
    """Read a positive, finite number."""
    value = _float(text)
    if not 0.0 < value < float('inf'):
        raise argparse.ArgumentTypeError(f"'{text}' is not a positive number; write one such as 16.0")
    return value


def non_negative(text: str) -> float:
    """Read a finite number of at least 0."""
    value = _float(text)
    if not 0.0 <= value < float('inf'):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of at least 0")
    return value


def fraction(text: str) -> float:
    """Read a number in [0, 1)."""
    value = non_negative(text)
    if not value < 1.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not in [0, 1); write one such as 0.2")
    return value


def whole_number(least: int, most: int | None = None) -> Callable[[str], int]:
    """Make a function that reads whole numbers of at least and at most so much, for an option's ``type``."""
    def read(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least {least}")
        if most is not None and value > most:
            raise argparse.ArgumentTypeError(f"'{text}' is too large; ask for at most {most}")
        return value

    return read


def given_values(options: argparse.Namespace, namespace: str = '/', extra: Sequence[str] = (),
                 extra_files: Sequence[str] = ()) -> Values:
    """Read the parameters that the shared options name, by node: robot, files, overrides; further ones win."""
    robot = [] if options.robot is None else [robot_file(options.robot)]
    return load([*robot, *options.params_files, *extra_files], [*options.overrides, *extra], namespace)


def configuration(options: argparse.Namespace, namespace: str = '/', extra: Sequence[str] = (),
                  extra_files: Sequence[str] = ()) -> Configuration:
    """
    Make the configuration that the shared options ask for.

    Parameters
    ----------
    options : Namespace
        Parsed by the parser of `make_parser`.
    namespace : str
        In which the nodes run.
    extra, extra_files : sequence of str
        Further overrides and files, which win.

    Returns
    -------
    Configuration
        Checked. Where `plant.initial_pose` is not given, the robot starts at the cart's start.

    Raises
    ------
    ParameterError
        Naming every violation.

    """
    values = given_values(options, namespace, extra, extra_files)
    # what a law prints while it prepares its gains must not be among the results
    with contextlib.redirect_stdout(sys.stderr):
        made = configure(values)
        return made if 'initial_pose' in values['plant'] else at_cart_start(made)


def configuration_text(parameters: Configuration, robot: str | None = None) -> str:
    """Return a configuration as a parameter file that gives the same numbers to the last bit, headed by its robot."""
    text = parameter_file_text({node: flatten(part) for node, part in parameters._asdict().items()})
    return text if robot is None else f'# robot: {printable(robot)}\n{text}'


def distinct(names: Sequence[str]) -> list[str]:
    """
    Number the names that occur more than once.

    Examples
    --------
    >>> distinct(['fuzzy', 'hybrid', 'fuzzy'])
    ['fuzzy_1', 'hybrid', 'fuzzy_2']

    """
    made: list[str] = []
    for n, name in enumerate(names):
        numbers = itertools.count(names[:n + 1].count(name))
        # a number that another name has already is left out
        made.append(name if names.count(name) == 1 else next(
            numbered for number in numbers if (numbered := f'{name}_{number}') not in {*made, *names}))
    return made


def writable_file(path: str) -> Path:
    """Return a file's path after checking that it can be written, before anything long; raise OSError if it cannot."""
    file = Path(path)
    check_regular(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open('a'):
        return file


def make_main(
    name: str, parse: Callable[[Sequence[str] | None], argparse.Namespace], run: Callable[[argparse.Namespace], int],
) -> Callable[..., int]:
    """
    Make the entry point of a command.

    Parameters
    ----------
    name : str
        Of the command, before each error text.
    parse : callable
        Reads a command line; that of the process where it is None.
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
        try:
            code = run(parse(arguments))
            flush_output()
            return code
        except ParameterError as error:
            for violation in error.violations:
                print(f'{name}: {printable(violation)}', file=sys.stderr)
            return 2
        except BrokenPipeError:
            discard_output()
            print(f'{name}: nothing reads the standard output any more; what is written to files is complete',
                  file=sys.stderr)
            return 1
        except OSError as error:
            discard_output()
            print(f'{name}: {printable(explain(error))}', file=sys.stderr)
            return 1 if is_disk_full(error) else 2
        except ModuleNotFoundError as error:
            print(f'{name}: the Python module {error.name} is missing; install it with rosdep or pip', file=sys.stderr)
            return 2
        except KeyboardInterrupt:
            print(f'{name}: interrupted', file=sys.stderr)
            return 1

    return main
