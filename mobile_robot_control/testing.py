"""
Check a law, a velocity law or a curve of one's own.

In a test: ``check_law(LAW)``. By hand: ``python -m mobile_robot_control.testing FILE.py``.
"""

import argparse
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mobile_robot_control.conformance.checks import Conformance
    from mobile_robot_control.control.law import Law
    from mobile_robot_control.control.velocity_law import VelocityLaw
    from mobile_robot_control.reference.curves import Curve


def check_law(law: 'Law', over_dds: bool = True) -> 'Conformance':
    """
    Check the requirements of a position law; all checks run before the error is raised.

    Parameters
    ----------
    law : Law
        The record; it is not registered by the check, and need not be.
    over_dds : bool
        Whether to run the law over DDS, too, if rclpy is installed: one simulated second, which takes some seconds.

    Returns
    -------
    Conformance
        The passed checks, and those left out, with the reason. Its text has a line for each.

    Raises
    ------
    ConformanceError
        An AssertionError that names each failed check with the input that shows it; `failures` has them by name.

    Warns
    -----
    ConformanceWarning
        If the law does not compile, or if its compiled form differs in last bits, with file and line.

    Examples
    --------
    >>> from mobile_robot_control.control.backstepping import LAW
    >>> check_law(LAW, over_dds=False).passed[:4]
    ('record', 'pure', 'inputs unchanged', 'finite')

    """
    # imported late, here and below: not every test that imports this module runs a check
    from mobile_robot_control.conformance.laws import checked_law  # noqa: PLC0415

    return checked_law(law, over_dds)


def check_velocity_law(law: 'VelocityLaw', over_dds: bool = True) -> 'Conformance':
    """
    Check the requirements of a velocity law; all checks run before the error is raised.

    Parameters
    ----------
    law : VelocityLaw
        The record; it is not registered by the check, and need not be.
    over_dds : bool
        Whether to run the law over DDS, too, if rclpy is installed.

    Returns
    -------
    Conformance
        The passed checks, and those left out, with the reason.

    Raises
    ------
    ConformanceError
        An AssertionError that names each failed check with the input that shows it.

    Examples
    --------
    >>> from mobile_robot_control.control.velocity_pi import LAW
    >>> check_velocity_law(LAW, over_dds=False).passed[:4]
    ('record', 'pure', 'finite', 'limit')

    """
    from mobile_robot_control.conformance.velocity_laws import checked_velocity_law  # noqa: PLC0415

    return checked_velocity_law(law, over_dds)


def check_curve(curve: 'Curve', over_dds: bool = True) -> 'Conformance':
    """
    Check the requirements of a curve; all checks run before the error is raised.

    Parameters
    ----------
    curve : Curve
        The record; it is not registered by the check, and need not be.
    over_dds : bool
        Whether to drive the curve over DDS, too, if rclpy is installed.

    Returns
    -------
    Conformance
        The passed checks, and those left out, with the reason.

    Raises
    ------
    ConformanceError
        An AssertionError that names each failed check with the curve parameter that shows it.

    Examples
    --------
    >>> from mobile_robot_control.reference.curves import CURVES
    >>> print(check_curve(CURVES['line'], over_dds=False))
    the curve 'line':
      passed: record
      passed: pure
      passed: finite
      passed: derivatives
      passed: speed
      left out: closed (the curve is open)
      left out: over DDS (over_dds=False)

    """
    from mobile_robot_control.conformance.curves import checked_curve  # noqa: PLC0415

    return checked_curve(curve, over_dds)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='mobile_robot_control.testing', allow_abbrev=False,
                                     description='check the LAW, the VELOCITY_LAW and the CURVE of a Python file')
    parser.add_argument('file', metavar='FILE.py', help='has a LAW, a VELOCITY_LAW, a CURVE or several')
    parser.add_argument('--no-dds', action='store_false', dest='over_dds', help='leave out the run over DDS')
    return parser


def _run(options: argparse.Namespace) -> int:
    """Check the records of a file; return 1 if any check fails."""
    from mobile_robot_control.conformance.checks import records_of  # noqa: PLC0415

    laws, velocity_laws, curves = records_of(options.file)
    names = [*(law.name for law in laws), *(law.name for law in velocity_laws), *(curve.name for curve in curves)]
    print(f'testing: checking {", ".join(names)}, for some seconds', file=sys.stderr)
    checks: list[Callable[[], Conformance]] = [
        *(partial(check_law, law, options.over_dds) for law in laws),
        *(partial(check_velocity_law, law, options.over_dds) for law in velocity_laws),
        *(partial(check_curve, curve, options.over_dds) for curve in curves)]
    failed = [check for check in checks if not _printed(check)]
    return 1 if failed else 0


def _printed(check: 'Callable[[], Conformance]') -> bool:
    """Run a check and print its findings; return whether it passed."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter('always')
        try:
            print(check())
        except AssertionError as error:
            print(f'testing: {error}', file=sys.stderr)
            return False
        finally:
            for warning in caught:
                print(f'testing: {warning.message}', file=sys.stderr)
    return True


def main(arguments: Sequence[str] | None = None) -> int:
    """Check a file; return the exit code: 0 passed, 1 failed, 2 if the file cannot be checked."""
    from mobile_robot_control.cli import make_main  # noqa: PLC0415

    return int(make_main(_parser, _run)(arguments))


if __name__ == '__main__':
    sys.exit(main())
