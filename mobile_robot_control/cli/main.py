"""How every command is run: its exit codes, and errors as messages."""

import argparse
import sys
from collections.abc import Callable, Sequence

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.system.files import explain, is_disk_full
from mobile_robot_control.system.streams import discard_output, flush_output, prepare_streams
from mobile_robot_control.system.texts import printable


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
            code = run(parser.parse_args(arguments))
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
