"""The fit of a base: its start values, and the choice of limits and dead zones that the data show."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.identification.estimation import Z95, Estimate, Model, estimate, whitened
from mobile_robot_control.identification.recorded import Recorded, cut
from mobile_robot_control.identification.velocity_drive import (
    COARSE_STEP,
    DEAD_ZONES,
    DELAYS,
    GAINS,
    LAGS,
    QUANTA,
    SECOND_LAGS,
    STEP,
    base_model,
    simulated,
)
from mobile_robot_control.model.base import Base
from mobile_robot_control.model.robot import Robot

_LAGS = (0.01, 0.03, 0.06, 0.12, 0.25, 0.5, 1.0)
_DELAYS = np.arange(-0.1, 0.8, 0.02)
_SHARES = (0.15, 0.3, 0.5, 0.7, 0.85, 0.95)
_LEAST_FIT = 0.3
"""Share of the motion that a command must explain."""
_WORTH = 6.0
"""A new parameter must raise the log-likelihood by so many times the logarithm of the number of samples."""
_SHORTEST_RAMP = 0.02
"""[s]: an acceleration limit that the largest command reaches sooner counts as none."""
_LONG = 180.0
"""[s] of recordings in which limits are sought."""
_MOST_LEVELS = 60
_SMALL = 0.35
"""Share of the largest command below which a dead zone is sought."""
_LEAST = (0.03, 0.06)
"""[m/s, rad/s]: a command with no larger variation is no excitation."""
_SECOND = 0.2
"""A second lag above this share of the first one counts."""
_NO_LAG = 2e-3
"""[s]: a lag below it ends at the bound of its search."""
_QUANTA = np.geomspace(0.01, 0.4, 40)
"""Shares of the largest command that are tried as its quantum."""
_CHI2 = 3.84
"""95 % quantile of the square of a normal variable."""


class BaseFit(NamedTuple):
    """
    A base fitted to recordings.

    Attributes
    ----------
    estimate : Estimate
        Of all parameters except dead zones.
    zones : dict of str to tuple of float
        Value, and bounds of its 95 % interval, of each dead zone and each quantum found.
    fixed : dict of str to float
        Parameters that were not estimated, including the values of dead zones.
    excited : tuple of bool
        Whether the commands of v and ω vary enough.
    second_lags : dict of str to tuple of float
        First and second lag [s] of each velocity, 'v' or 'ω', that follows with two of them.
    """

    estimate: Estimate
    zones: dict[str, tuple[float, float, float]]
    fixed: dict[str, float]
    excited: tuple[bool, bool]
    second_lags: dict[str, tuple[float, float]]


class NothingFollowsError(Exception):
    """Odometry does not follow the commands."""


def excited_by(recordings: Sequence[Recorded]) -> tuple[bool, bool]:
    """Return whether the commands of v and ω vary enough, and move the robot."""
    ranges = [np.ptp(one.commands.values, axis=0) for one in recordings if one.commands]
    moves = [np.ptp(one.motion.speeds[one.motion.usable], axis=0) for one in recordings
             if one.motion and one.motion.usable.any()]
    if not ranges or not moves:
        return False, False
    varies = (np.max(ranges, axis=0) > _LEAST) & (np.max(moves, axis=0) > np.array(_LEAST))
    return bool(varies[0]), bool(varies[1])


class _Search:
    """The data shared by all steps of a search."""

    def __init__(
        self, recordings: Sequence[Recorded], robot: Robot, configured: Base, tell: Callable[[], object], step: int
    ) -> None:
        self._recordings, self._robot, self._given, self.tell, self._step = recordings, robot, configured, tell, step
        self.measured = [one.motion.moved[one.motion.usable] for one in recordings if one.motion]

    def model(self, start: Mapping[str, float], fixed: Mapping[str, float]) -> Model:
        return base_model(self._recordings, start, fixed, self._robot, self._given, self._step)

    def estimate(self, start: Mapping[str, float], fixed: Mapping[str, float], rounds: int = 2) -> Estimate:
        return estimate(self.model(start, fixed), self.measured, rounds, self.tell)

    def cost(self, values: Mapping[str, float], fixed: Mapping[str, float], like: Estimate) -> float:
        """Return the sum of squared residuals, whitened with the noise of an estimate."""
        model = self.model(values, fixed)
        residuals = [one - other for one, other in zip(self.measured, model.outputs(model.start), strict=True)]
        return float((whitened(residuals, like.noise) ** 2).sum())

    def start(self, excited: Sequence[bool]) -> dict[str, float]:
        """Return approximate lags, delays and gains: the best of a grid, for each velocity separately."""
        best: list[tuple[float, float, float, float]] = [(np.inf, 0.12, 0.0, 1.0)] * 2
        for lag in _LAGS:
            runs = [simulated(one, dict.fromkeys(LAGS, lag), self._robot, self._given, self._step)
                    for one in self._recordings]
            for delay in _DELAYS.tolist():
                modelled = np.concatenate([
                    np.diff(run.at(one.motion.times, (delay, delay)), axis=0)[one.motion.usable]
                    for one, run in zip(self._recordings, runs, strict=True) if one.motion])
                measured = np.concatenate(self.measured)
                for n in (0, 1):
                    own = float(modelled[:, n] @ modelled[:, n])
                    gain = float(modelled[:, n] @ measured[:, n]) / own if own > 0.0 else 0.0
                    left = float(((measured[:, n] - gain * modelled[:, n]) ** 2).sum())
                    best[n] = min(best[n], (left, lag, delay, gain))
            self.tell()
        whole = (np.concatenate(self.measured) ** 2).sum(axis=0)
        if any(is_excited and best[n][0] > (1.0 - _LEAST_FIT) * whole[n] for n, is_excited in enumerate(excited)):
            name = next(name for n, name in enumerate(('v', 'ω')) if excited[n] and best[n][0] > (
                1.0 - _LEAST_FIT) * whole[n])
            raise NothingFollowsError(
                f'{name} of odometry does not follow the commands: they explain less than {_LEAST_FIT:.0%} of it; '
                'is this the cmd_vel that drove the robot, and its odometry (--topic)?')
        values: dict[str, float] = {}
        for n, is_excited in enumerate(excited):
            if is_excited:
                values |= {LAGS[n]: best[n][1], DELAYS[n]: best[n][2]}
        linear, angular = (best[n][3] if is_excited else 1.0 for n, is_excited in enumerate(excited))
        if excited[0]:
            values |= dict.fromkeys(GAINS[:2], float(np.clip(linear, 0.6, 1.4)))
        if excited[1]:
            values[GAINS[2]] = float(np.clip(angular / (linear if excited[0] else 1.0), 0.3, 1.4))
        return values

    def speeds(self, n: int) -> Floats:
        """Return measured speeds of v or ω [1/s]."""
        found: Floats = np.abs(np.concatenate([one.motion.speeds[one.motion.usable, n] for one in self._recordings
                                               if one.motion]))
        return found

    def commands(self, n: int) -> Floats:
        """Return the absolute values of the commands of v or ω."""
        found: Floats = np.abs(np.concatenate([one.commands.values[:, n] for one in self._recordings if one.commands]))
        return found


def fit_base(
    recordings: Sequence[Recorded], robot: Robot, configured: Base, tell: Callable[[], object] = lambda: None
) -> BaseFit:
    """
    Fit a base to recordings.

    Limits and dead zones are added one by one, as long as the likelihood grows significantly.

    Raises
    ------
    NothingFollowsError
        If odometry does not follow the commands.
    """
    excited = excited_by(recordings)
    # a few minutes show the limits as well as an hour
    search = _Search([cut(one, _LONG / len(recordings)) for one in recordings], robot, configured, tell, COARSE_STEP)
    fixed: dict[str, float] = {}
    zones: dict[str, tuple[float, float, float]] = {}
    estimated = search.estimate(search.start(excited), fixed, 1)
    channels = [n for n, is_excited in enumerate(excited) if is_excited]
    for _ in range(2):
        for name in ('max_speed', 'max_acceleration'):
            for n in channels:
                estimated = _with_limit(search, estimated, fixed, f'base.{name}[{n}]', n)
        for n in channels:
            estimated = _with_dead_zone(search, estimated, fixed, zones, n)
    for n in channels:
        estimated = _with_quantum(search, estimated, fixed, zones, n)
        if f'base.max_acceleration[{n}]' in estimated.names:
            estimated = _with_limit(search, estimated, fixed, f'base.max_deceleration[{n}]', n)
    final = _Search(recordings, robot, configured, tell, STEP)
    for n in channels:
        if DEAD_ZONES[n] in zones:
            zone = _zone(final, final.estimate(_values(estimated), fixed, 1), fixed, n)
            if zone is None or zone[1] == 0.0:
                del zones[DEAD_ZONES[n]], fixed[DEAD_ZONES[n]]
            else:
                zones[DEAD_ZONES[n]], fixed[DEAD_ZONES[n]] = zone, zone[0]
    last = final.estimate(_without_what_is_not_told(estimated), fixed, 3)
    shown = _without_lags_that_may_be_none(last)
    return BaseFit(last if len(shown) == len(last.names) else final.estimate(shown, fixed, 3), zones, fixed, excited,
                   _second_lags(search, estimated, fixed, channels))


def _second_lags(
    search: _Search, before: Estimate, fixed: Mapping[str, float], channels: Sequence[int]
) -> dict[str, tuple[float, float]]:
    """Return first and second lag of each velocity for which the data show two."""
    values = _values(before)
    start = values | {LAGS[n]: 0.6 * values[LAGS[n]] for n in channels} | {
        DELAYS[n]: 0.5 * values[DELAYS[n]] for n in channels} | {
        SECOND_LAGS[n]: max(0.01, 0.4 * values[LAGS[n]] + 0.3 * values[DELAYS[n]]) for n in channels}
    after = search.estimate(start, fixed)
    search.tell()
    if not _is_worth(before, after):
        return {}
    lags = {'vω'[n]: tuple(sorted((_values(after)[LAGS[n]], _values(after)[SECOND_LAGS[n]]))) for n in channels}
    return {name: (larger, smaller) for name, (smaller, larger) in lags.items() if smaller > max(
        _NO_LAG, _SECOND * larger)}


def _without_what_is_not_told(estimated: Estimate) -> dict[str, float]:
    """Return the values of an estimate, without limits whose interval is wider than their value."""
    widths = dict(zip(estimated.names, Z95 * estimated.deviations, strict=True))
    return {name: value for name, value in _values(estimated).items()
            if not name.startswith('base.max_') or widths[name] < value}


def _without_lags_that_may_be_none(estimated: Estimate) -> dict[str, float]:
    """Return the values of an estimate, without lags that do not show beside the dead time."""
    return {name: value for (name, value), deviation in zip(
        _values(estimated).items(), estimated.deviations.tolist(), strict=True)
        if name not in LAGS or value > max(_NO_LAG, Z95 * deviation)}


def _values(estimated: Estimate) -> dict[str, float]:
    return dict(zip(estimated.names, estimated.values.tolist(), strict=True))


def _is_worth(before: Estimate, after: Estimate) -> bool:
    return before.cost - after.cost > 2.0 * _WORTH * float(np.log(before.whitened.shape[0]))


def _with_limit(search: _Search, before: Estimate, fixed: Mapping[str, float], name: str, n: int) -> Estimate:
    """Return an estimate with one more limit if the data show it; otherwise the previous one."""
    values = _values(before)
    if name in values:
        return before
    if name.startswith('base.max_speed'):
        largest = float(np.quantile(search.speeds(n), 0.99))
        starts = [(largest * factor, 1.0) for factor in (0.9, 0.97, 1.0)]
        if float(search.commands(n).max()) <= 0.97 * largest:
            return before
    elif name.startswith('base.max_deceleration'):
        starts = [(values[f'base.max_acceleration[{n}]'] * factor, 1.0) for factor in (0.5, 0.8, 1.25, 2.0)]
    else:
        # the largest change of a command by the lag alone
        steepest = 2.0 * float(search.commands(n).max()) / max(values[LAGS[n]], 0.02)
        starts = [(steepest * share, factor) for share in _SHARES for factor in (1.0, 0.5, 0.2)]

    def beginning(limit: float, factor: float) -> dict[str, float]:
        return values | {name: limit, LAGS[n]: max(2e-3, values[LAGS[n]] * factor)}

    best = min(starts, key=lambda one: search.cost(beginning(*one), fixed, before))
    search.tell()
    after = search.estimate(beginning(*best), fixed, 1)
    acts = name.startswith('base.max_speed') or search.commands(n).max() > _SHORTEST_RAMP * _values(after)[name]
    return after if acts and _is_worth(before, after) else before


def _with_dead_zone(
    search: _Search, before: Estimate, fixed: dict[str, float], zones: dict[str, tuple[float, float, float]], n: int
) -> Estimate:
    """Return an estimate with a dead zone if the data show it, and add the zone to `fixed` and `zones`."""
    name = DEAD_ZONES[n]
    zone = _zone(search, before, fixed, n)
    search.tell()
    if zone is None:
        return before
    after = search.estimate(_values(before), {**fixed, name: zone[0]}, 1)
    if not _is_worth(before, after):
        return before
    fixed[name], zones[name] = zone[0], zone
    return after


def _with_quantum(
    search: _Search, before: Estimate, fixed: dict[str, float], zones: dict[str, tuple[float, float, float]], n: int
) -> Estimate:
    """Return an estimate with rounded commands if the data show it, and add the quantum to `fixed` and `zones`."""
    name, values, largest = QUANTA[n], _values(before), float(search.commands(n).max())
    # rounding holds small commands back, as a dead zone does
    others = {other: value for other, value in fixed.items() if other != DEAD_ZONES[n]}

    def costs(quanta: Floats) -> Floats:
        return np.array([search.cost(values, {**others, name: quantum}, before) for quantum in quanta.tolist()])

    best = largest * float(_QUANTA[costs(largest * _QUANTA).argmin()])
    near = best * np.linspace(0.95, 1.05, 41)
    near_costs = costs(near)
    search.tell()
    best, likely = float(near[near_costs.argmin()]), near[near_costs - near_costs.min() < _CHI2]
    after = search.estimate(values, {**others, name: best}, 1)
    if not _is_worth(before, after):
        return before
    step = float(near[1] - near[0])
    for found_so_far in (fixed, zones):
        found_so_far.pop(DEAD_ZONES[n], None)
    fixed[name], zones[name] = best, (best, float(likely[0]) - step, float(likely[-1]) + step)
    return _with_dead_zone(search, after, fixed, zones, n)


def _zone(
    search: _Search, estimated: Estimate, fixed: Mapping[str, float], n: int
) -> tuple[float, float, float] | None:
    """Return a dead zone and the bounds of its 95 % interval, from the likelihood of each; None if none is better."""
    # a recording shows only between which of its commands the zone ends
    commands, values = search.commands(n), _values(estimated)
    levels = np.unique(commands[(commands > 0.0) & (commands < _SMALL * commands.max())].round(6))
    if levels.size == 0:
        return None
    above = commands[commands > levels[-1]].min()
    levels = np.unique(np.quantile(levels, np.linspace(0.0, 1.0, min(_MOST_LEVELS, levels.size)), method='nearest'))
    edges = np.concatenate([[0.0], levels, [above]])
    middles = 0.5 * (edges[1:] + edges[:-1])
    costs = np.array([search.cost(values, {**fixed, DEAD_ZONES[n]: zone}, estimated) for zone in middles.tolist()])
    best = int(costs.argmin())
    if best == 0:
        return None
    likely = np.flatnonzero(costs - costs[best] < _CHI2)
    return float(middles[best]), float(edges[likely[0]]), float(edges[likely[-1] + 1])
