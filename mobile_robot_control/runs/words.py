"""
Quantities and the outcome of a run as short texts; web/scene.js has the same rule for scripts.

In tables the exact value appears under the pointer.
"""

import math
from collections.abc import Collection, Iterable, Sequence
from html import escape
from typing import Any, NamedTuple

from mobile_robot_control.loop.indices import MEASURED
from mobile_robot_control.model.plant import VELOCITY
from mobile_robot_control.runs.metrics import RECORDED
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.system.texts import shortened

_NO_BREAK = '\u00a0'
_PREFIXES = ((1e-4, 1e6, 'µ'), (0.1, 1e3, 'm'), (math.inf, 1.0, ''))
"""A factor and its prefix for sizes below a bound."""
_MOST = 1e4
"""Number from which a larger unit is better."""


class Unit(NamedTuple):
    """
    A display unit of a quantity.

    Attributes
    ----------
    name : str
        Such as 'mm'.
    factor : float
        Multiplier of a value in SI units.
    """

    name: str
    factor: float


def readable_unit(values: Iterable[float | None], unit: str) -> Unit:
    """
    Return one display unit for some values [SI], so that the smallest has few digits.

    Examples
    --------
    >>> readable_unit([0.009667, None, 0.132], 'm'), readable_unit([0.012], 'rad').name
    (Unit(name='mm', factor=1000.0), '°')

    """
    if unit == 'rad':
        return Unit('°', math.degrees(1.0))
    sizes = [abs(value) for value in values if value is not None and math.isfinite(value) and value != 0.0]
    if not unit or unit.startswith('m²') or not sizes:
        return Unit(unit, 1.0)
    return next(Unit(prefix + unit, factor) for below, factor, prefix in _PREFIXES
                if factor == 1.0 or (min(sizes) < below and max(sizes) * factor < _MOST))


def readable(value: float | None, unit: str, shown: Unit | None = None) -> str:
    r"""
    Return a quantity with three digits and a prefix, on one line by no-break spaces; a dash if it is unknown.

    Without a given unit, the unit follows from its own size.

    Examples
    --------
    >>> readable(0.009667, 'm'), readable(1234.5, 'N m'), readable(None, 'J')
    ('9.67\xa0mm', '1230\xa0N\xa0m', '–')

    """
    if value is None or not math.isfinite(value):
        return '–'
    name, factor = shown or readable_unit([value], unit)
    return _joined(three_digits(factor * value), name)


def three_digits(value: float) -> str:
    """
    Return a number with three significant digits, as short as it can be.

    Examples
    --------
    >>> three_digits(1234.5), three_digits(0.30000001), three_digits(-2e9)
    ('1230', '0.3', '-2000000000')

    """
    rounded = float(f'{value:.3g}')
    return f'{rounded:.0f}' if 1000.0 <= abs(rounded) < 1e21 else f'{rounded:g}'


def quantity(value: float | None, unit: str, shown: Unit | None = None) -> str:
    """
    Return a value [SI] in a readable unit, as HTML with the exact value as its title; a dash for None.

    Parameters
    ----------
    value : float or None
        In the SI unit.
    unit : str
        The SI unit.
    shown : Unit or None
        Display unit; if None, chosen by the value's size.
    """
    if value is None:
        return '–'
    name, factor = shown or readable_unit([value], unit)
    exact = escape(f'{value!r} {unit}'.rstrip())
    return f'<data value="{value!r}" title="{exact}">{_joined(three_digits(factor * value), name)}</data>'


def quantities(values: Sequence[float | None], unit: str) -> list[str]:
    """Return values [SI] as `quantity` does, all in the same readable unit."""
    shown = readable_unit(values, unit)
    return [quantity(value, unit, shown) for value in values]


def described_change(value: float, base: float, unit: str) -> str:
    r"""
    Return the difference of a value from another one, both in an SI unit, as a text: readable, and in per cent.

    Examples
    --------
    >>> described_change(0.09, 0.12, 'm'), described_change(0.0, 0.0, '')
    ('−30\xa0mm, −25\xa0%', '±0')

    """
    apart = value - base
    if apart == 0.0:
        return _joined('±0', unit)
    sign = '+' if apart > 0.0 else '−'
    share = ', ' + _joined(f'{sign}{three_digits(100.0 * abs(apart / base))}', '%') if base else ''
    return sign + readable(abs(apart), unit) + share


def _joined(number: str, unit: str) -> str:
    """Return a number and its unit, on one line; a degree sign follows without a space."""
    return (number + (unit if unit in ('', '°') else f' {unit}')).replace(' ', _NO_BREAK)


_ENDS = {
    'completed': 'completed {}', 'diverged': 'diverged after {}', 'not known': 'drove for {}',
    'law_failed': 'was stopped after {}, when its law failed',
    'interrupted': 'was interrupted after {}', 'node_died': 'was broken off after {}, when a node gave no answer',
    'broken off': 'was recorded for {} only', RECORDED: 'was recorded for {}',
}
"""Texts by outcome, with the duration of the run."""
WHOLE = ('completed', 'not known', RECORDED)
"""Outcomes of runs with their full length."""


def run_sentence(
    metrics: dict[str, Any], parameters: Configuration | None, on_wall_clock: bool = False, laws: int = 1,
    others: Collection[str] = (),
) -> str:
    """
    Describe the outcome of a run, without a full stop.

    Parameters
    ----------
    metrics : dict of str to object
        As in metrics.json; only measured ones.
    parameters : Configuration or None
        Of the run; None if unknown.
    on_wall_clock : bool
        Whether it ran on the wall clock.
    laws : int
        Number of laws in sequence.
    others : collection of str
        Nodes of somebody else.

    """
    end = f'{run_end(metrics, parameters, on_wall_clock)}: {run_facts(metrics, parameters)}'
    if parameters is None:
        return f'The robot {end}'
    law = f'a run of {laws} laws' if laws > 1 else law_words(parameters, others)
    course = ('the reference of another cart' if 'reference_cart' in others
              else f'the {parameters.reference_cart.curve.curve}')
    return f'On {course}, {law} {end}'


def law_words(parameters: Configuration, others: Collection[str] = ()) -> str:
    """Return the name of a run's position law, in words; that of somebody else's controller is not known."""
    return ('another position controller' if 'position_controller' in others
            else parameters.position_controller.control.controller_type.replace('_', ' '))


def run_end(metrics: dict[str, Any], parameters: Configuration | None, on_wall_clock: bool) -> str:
    """Describe the outcome of a run, with its time."""
    outcome, duration = metrics.get('outcome', 'not known'), metrics.get('duration')
    if duration is None:
        return f'was not measured (outcome {shortened(str(outcome), 40)})'
    planned = parameters.plant.duration if parameters else 0.0
    lasted = readable(duration, 's')
    if outcome not in WHOLE and planned > duration:
        lasted += f' of {readable(planned, "s")}'
    # the outcome may be any text
    end = _ENDS.get(outcome, 'ended after {}').format(lasted + (' on the wall clock' if on_wall_clock else ''))
    return end if outcome in _ENDS else f'{end} ({shortened(str(outcome), 40)})'


def run_facts(metrics: dict[str, Any], parameters: Configuration | None) -> str:
    """Describe errors and peak torque of a run."""
    return f'{_errors(metrics)}, {_torque(metrics, parameters)}'


def _errors(metrics: dict[str, Any]) -> str:
    rms, largest = metrics.get('rms_position_error'), metrics.get('max_position_error')
    if rms is None:
        return 'its error is not known'
    if metrics.get('error') == MEASURED:
        return f'RMS error {readable(rms, "m")} and largest {readable(largest, "m")} as odometry saw it'
    seen = metrics.get('measured_rms_position_error')
    hidden = '' if seen in (None, rms) else f' ({readable(seen, "m")} as odometry saw it)'
    return f'{"true " if hidden else ""}RMS error {readable(rms, "m")}{hidden}, largest {readable(largest, "m")}'


def peak_torque(metrics: dict[str, Any]) -> float | None:
    """Return the largest absolute torque of either wheel [N m]; None if it was not measured."""
    peaks = (metrics.get('peak_wheel_torque') or {}).values()
    known = [peak for peak in peaks if peak is not None]
    return max(known) if known else None


def _torque(metrics: dict[str, Any], parameters: Configuration | None) -> str:
    peak = peak_torque(metrics)
    if peak is not None:
        return f'peak torque {readable(peak, "N m")}'
    takes_none = parameters is not None and parameters.plant.model.drive == VELOCITY
    return 'no torque, as its base takes velocities' if takes_none else 'torque not known'
