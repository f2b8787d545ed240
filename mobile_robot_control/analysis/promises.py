"""The validity of the numbers of a search or study: the modelled effects, and the margins of the loops."""

import math
import statistics
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.analysis.margins import (
    LARGEST_GAIN,
    MOST_PERIODS,
    LapMargins,
    LoopMargins,
    longest_delay,
    loop_margins,
)
from mobile_robot_control.analysis.modelled import Described, describe_model, drive_of
from mobile_robot_control.loop.monte_carlo import Scenarios
from mobile_robot_control.loop.scenarios import COULOMB, Scenario
from mobile_robot_control.model.plant import VELOCITY
from mobile_robot_control.settings.nodes import Configuration, latency_cautions
from mobile_robot_control.system.texts import as_lines

THIN_GAIN = 2.0
"""6 dB: a gain margin below it is thin."""
THIN_PERIODS = 2.0
"""A delay margin of fewer periods of its loop is thin."""
THIN_DELAY = 0.05
"""[s]: a delay margin of the position loop below it is thin."""

_UNKNOWN = 'a robot with any of these effects may have another error'
_REMEDY = 'Measure each on your robot, then set its parameter, or name it in plant.ruled_out'


class Promise(NamedTuple):
    """
    The validity of the numbers that a command gives for a controller.

    Attributes
    ----------
    described : Described
        The modelled effects.
    margins : LoopMargins
        Of both loops.
    velocity_period, position_period : float
        [s]
    lockstep : bool
        Whether the nodes add no sample of delay.
    cautions : tuple of str
        Sentences about the configuration itself.
    spread : tuple of float
        RMS errors of the configured run over some seeds [m], in ascending order; () if nothing is random.

    """

    described: Described
    margins: LoopMargins
    velocity_period: float
    position_period: float
    lockstep: bool
    cautions: tuple[str, ...] = ()
    spread: tuple[float, ...] = ()


def promise(configuration: Configuration, scenarios: Sequence[Scenario]) -> Promise:
    """Return the validity of numbers from a checked configuration in some scenarios."""
    shared = configuration.plant.shared
    return Promise(describe_scenarios(configuration, scenarios), loop_margins(configuration),
                   1.0 / shared.velocity_rate, 1.0 / shared.position_rate, shared.lockstep,
                   tuple(latency_cautions(configuration.position_controller)))


def describe_scenarios(configuration: Configuration, scenarios: Sequence[Scenario]) -> Described:
    """Return the modelled effects of a checked configuration in scenarios: these set delay, noise, perhaps friction."""
    columns = Scenarios.of(scenarios)
    delays = sorted(set(columns.delay.tolist()))
    span = f'{delays[0]} to {delays[-1]}' if len(delays) > 1 else f'{delays[0]}'
    times = [f'{span} velocity periods'] if delays[-1] else []
    moved, base = 'motors', configuration.plant.model.base
    if drive_of(configuration) == VELOCITY:
        moved = 'base'
        if any(base.dead_time):
            times.insert(0, f'{" and ".join(f"{time:g}" for time in base.dead_time)} s')
    noise = scenarios[0].noise
    strength = ' and '.join(f'{value:g} {unit}' for value, unit in zip(
        (*noise.pose, noise.velocity), ('m', 'm', 'rad', 'rad/s'), strict=True))
    rubbing = columns.robots[:, columns.robot_names.index(COULOMB)] if COULOMB in columns.robot_names else ()
    return describe_model(configuration, {
        **({'Coulomb friction': f'{min(rubbing):g} to {max(rubbing):g} N m'} if any(rubbing) else {}),
        f'dead time of the {moved}': ' and '.join(times),
        'noise': strength if any((*noise.pose, noise.velocity)) else '',
    })


def _shrink(multiplier: float) -> str:
    return f'shrink to {multiplier:.2g} of themselves in a lap'


def _shortfalls(
    name: str, worst: LapMargins, period: float, least: float, multiplier: float = math.nan
) -> Iterator[str]:
    """Yield the thin margins of a loop; the delay margin must be at least `least` [s]."""
    gain, lowest, delay = worst.margins
    if multiplier >= 1.0:
        yield f'the {name} loop is not stable: an error grows to {multiplier:.3g} of itself in a lap; lower the gains'
        return
    if gain <= 1.0:
        yield (f'the {name} loop is not stable at {_place(worst.gain_time)}; lower the gains' if math.isnan(multiplier)
               else f'errors of the {name} loop grow around {_place(worst.gain_time)}, and {_shrink(multiplier)}: no '
               'margin is known there')
        return
    if gain < THIN_GAIN:
        yield f'the {name} loop has a thin gain margin, {gain:.2f}, and {THIN_GAIN:g} is usual: lower the gains'
    if lowest > 1.0 / THIN_GAIN:
        yield (f'the {name} loop has a thin lower gain margin, {lowest:.2f}, and {1.0 / THIN_GAIN:g} is usual: raise '
               'the gains')
    if delay * period < least:
        yield (f'the {name} loop has a thin delay margin, {1e3 * delay * period:.1f} ms, and {1e3 * least:g} ms are '
               'little: lower the gains, or model what is late on the robot and search again')


def warnings_of(promise: Promise) -> list[str]:
    """Return warnings about numbers that a robot may not reproduce, each in a sentence."""
    warnings = _margin_warnings(promise)
    unknown = '; '.join(f'{phrase} ({find})' for phrase, find in promise.described.unknown.items())
    if unknown:
        warnings.append(f'not modelled, and {_UNKNOWN}: {unknown}. {_REMEDY}{_room(promise)}')
    return warnings


def _margin_warnings(promise: Promise) -> list[str]:
    """Return the warnings without those of effects that are not modelled."""
    margins, warnings = promise.margins, list(promise.cautions)
    if margins.reason:
        warnings.append(f'the margins are unknown: {margins.reason}')
    if margins.velocity is not None:
        # on the wall clock the nodes use up one or two samples of it
        periods = THIN_PERIODS if promise.lockstep else 2.0 * THIN_PERIODS
        warnings += _shortfalls('velocity', margins.velocity, promise.velocity_period,
                                periods * promise.velocity_period)
    warnings += _shortfalls('position', margins.position, promise.position_period,
                            max(THIN_DELAY, THIN_PERIODS * promise.position_period), margins.multiplier)
    return warnings


def _room(promise: Promise) -> str:
    """Describe the room for further delay."""
    gain, _, delay = promise.margins.position.margins
    if not math.isfinite(delay) or gain <= 1.0 or promise.margins.multiplier >= 1.0:
        return ''
    return f'; there is room for {1e3 * delay * promise.position_period:.0f} ms of delay before the loop is unstable'


def _place(time: float) -> str:
    return f't = {time:.3g} s of the lap'


def _gain_text(worst: LapMargins) -> str:
    gain, lowest, _ = worst.margins
    lower = f', lower gain margin {lowest:.2f}' if lowest else ''
    if math.isinf(gain):
        return f'gain margin more than {LARGEST_GAIN:g}{lower}'
    return f'gain margin {gain:.2f} at {_place(worst.gain_time)}{lower}'


def _loop_text(name: str, worst: LapMargins, period: float, longest: int, multiplier: float = math.nan) -> str:
    """Describe the margins of a loop; the delay margin was searched up to the longest [periods]."""
    if multiplier >= 1.0:
        return f'{name} loop: not stable, an error grows to {multiplier:.3g} of itself in a lap'
    lap = '' if math.isnan(multiplier) else f'; errors {_shrink(multiplier)}'
    delay = worst.margins.delay
    if math.isnan(delay):
        return f'{name} loop: margins unknown'
    if worst.margins.gain <= 1.0:
        place = _place(worst.gain_time)
        return f'{name} loop: errors grow around {place}{lap}' if lap else f'{name} loop: not stable at {place}'
    periods = f'more than {longest}' if math.isinf(delay) else f'{delay:.1f}'
    at = '' if math.isinf(delay) else f' at {_place(worst.delay_time)}'
    return (f'{name} loop: {_gain_text(worst)}, delay margin {1e3 * min(delay, longest) * period:.4g} ms '
            f'({periods} {name} periods){at}{lap}')


def promise_lines(promise: Promise) -> list[str]:
    """Return the promise as lines of text of at most 100 characters; a warning has what can be looked for."""
    described = promise.described
    left = [phrase for phrase in described.not_modelled if phrase not in described.unknown]
    return as_lines([*_described(described, f'{"; ".join(left)}: {_UNKNOWN}' if left else ''), *_margin_texts(promise),
                     *(f'warning: {text}' for text in warnings_of(promise))])


def brief_lines(promises: Sequence[Promise]) -> list[str]:
    """Return the promises of one or several loops as lines, with what all have in common once: warnings first."""
    texts = [f'warning: {text}' for one in promises for text in _margin_warnings(one)]
    for promise in promises:
        names = '; '.join(promise.described.not_modelled)
        texts += _described(promise.described, names and f'{names}: {_UNKNOWN}. {_REMEDY}')
    texts += (text for one in promises for text in _margin_texts(one))
    return as_lines(dict.fromkeys(texts))


def _described(described: Described, not_modelled: str) -> Iterator[str]:
    """Yield what is modelled, and what is not."""
    modelled = '; '.join(f'{phrase} ({text})' for phrase, text in described.modelled.items())
    yield f'modelled: {modelled or "none of what follows"}'
    if not_modelled:
        yield f'not modelled: {not_modelled}'
    if described.ruled_out:
        yield f'ruled out: {"; ".join(described.ruled_out)}'


def _margin_texts(promise: Promise) -> list[str]:
    """Return the margins, and what is not in them."""
    margins, texts = promise.margins, []
    if margins.velocity is not None:
        texts.append(_loop_text('velocity', margins.velocity, promise.velocity_period, MOST_PERIODS))
    texts.append(_loop_text('position', margins.position, promise.position_period,
                            longest_delay(promise.position_period), margins.multiplier))
    if promise.spread:
        texts.append(spread_text(promise.spread))
    if promise.described.not_in_margins:
        texts.append(f'not in the margins: {"; ".join(promise.described.not_in_margins)}')
    return texts


def spread_text(spread: Sequence[float]) -> str:
    """Describe the spread of a run's error due to random effects."""
    smallest, median, largest = (100.0 * error for error in (spread[0], statistics.median(spread), spread[-1]))
    return (f'RMS error of the configured run over {len(spread)} seeds: {median:.2f} cm, from {smallest:.2f} to '
            f'{largest:.2f} cm')


def promise_values(promise: Promise) -> dict[str, Any]:
    """Return the promise as in `study.json`; numbers beyond the range of the search are None."""
    def of(loop: LapMargins | None, period: float) -> dict[str, float | None] | None:
        if loop is None:
            return None
        return {'gain': _finite(loop.margins.gain), 'lowest_gain': _finite(loop.margins.lowest_gain),
                'gain_time': _finite(loop.gain_time), 'delay': _finite(loop.margins.delay * period),
                'delay_time': _finite(loop.delay_time)}

    return {
        'modelled': dict(promise.described.modelled),
        'not_modelled': list(promise.described.not_modelled),
        'ruled_out': list(promise.described.ruled_out),
        'rms_position_error_over_seeds': [_finite(error) for error in promise.spread],
        'margins': {'velocity_loop': of(promise.margins.velocity, promise.velocity_period),
                    'position_loop': of(promise.margins.position, promise.position_period),
                    'lap_multiplier': _finite(promise.margins.multiplier),
                    'not_in_margins': list(promise.described.not_in_margins)},
        'warnings': warnings_of(promise),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
