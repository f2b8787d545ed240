"""How checks are run: all of them first, then one error that names each that failed."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple, NoReturn

Check = Callable[[], Iterable[str]]
"""Yields what is wrong, each with the input that shows it; the first one counts."""


class ConformanceError(AssertionError):
    """
    A law or a curve that fails checks.

    Parameters
    ----------
    subject : str
        What was checked, such as "the law 'kanayama'".
    failures : mapping of str to str
        By check, what is wrong and the input that shows it.

    """

    def __init__(self, subject: str, failures: Mapping[str, str]) -> None:
        self.failures = dict(failures)
        checks = 'check' if len(self.failures) == 1 else 'checks'
        super().__init__('\n'.join([f'{subject} fails {len(self.failures)} {checks}:',
                                    *(f'  {name}: {text}' for name, text in self.failures.items())]))


class ConformanceWarning(UserWarning):
    """A law that passes, but does not compile, or whose compiled form differs in last bits."""


class LeftOutError(Exception):
    """Raised by a check that cannot be made here; the message is the reason."""


class Conformance(NamedTuple):
    """
    The checks that a law or a curve has passed, and those that were not made.

    Attributes
    ----------
    subject : str
        What was checked.
    passed : tuple of str
        Names of checks.
    left_out : dict of str to str
        By check, why it was not made.

    """

    subject: str
    passed: tuple[str, ...]
    left_out: dict[str, str]

    def __str__(self) -> str:
        """Return a line for each check."""
        return '\n'.join([f'{self.subject}:', *(f'  passed: {name}' for name in self.passed),
                          *(f'  left out: {name} ({reason})' for name, reason in self.left_out.items())])


def _found(check: Check) -> str | None:
    """Return the first thing that is wrong; None where nothing is."""
    try:
        return next(iter(check()), None)
    except LeftOutError:
        raise
    except Exception as error:  # a law or a curve can raise anything
        return f'{type(error).__name__}: {error}'


def run_checks(subject: str, checks: Mapping[str, Check]) -> Conformance:
    """Run checks by name, after that of the record; raise ConformanceError where any fails."""
    passed, failures, left_out = ['record'], {}, {}
    for name, check in checks.items():
        try:
            found = _found(check)
        except LeftOutError as reason:
            left_out[name] = str(reason)
            continue
        if found is None:
            passed.append(name)
        else:
            failures[name] = found
    if failures:
        raise ConformanceError(subject, failures)
    return Conformance(subject, tuple(passed), left_out)


def with_dds(checks: Mapping[str, Check], over_dds: Check, asked: bool) -> dict[str, Check]:
    """Return checks and the one over DDS, which is left out unless it is asked for."""
    def not_asked() -> Iterable[str]:
        raise LeftOutError('over_dds=False')

    return {**checks, 'over DDS': over_dds if asked else not_asked}


def refused(subject: str, violations: Iterable[str]) -> NoReturn:
    """Raise ConformanceError for a record that cannot be registered, or does not fit; no other check is made."""
    raise ConformanceError(subject, {'record': '; '.join(violations)})
