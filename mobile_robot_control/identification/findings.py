"""Texts on missing data of a recording, on open questions, and on missing parts of its model."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.identification.base_search import BaseFit, excited_by
from mobile_robot_control.identification.estimation import Estimate
from mobile_robot_control.identification.recorded import STILL, Recorded
from mobile_robot_control.identification.result import Prediction

_SHORTEST = 10.0
"""[s]: least motion for an identification."""
_LARGEST_LAG = 60
_NOTABLE = 0.1
"""Least reported correlation of residuals ..."""
_SURE = 5.0
"""... if it is so many times its random value."""
_SLIGHT = 0.01
"""Residuals below this share of the motion are not reported."""
_MISSED = 0.5
"""Share of a motion that another one may miss and still count as the same."""
_LATER = np.arange(0.0, 2.05, 0.1)
"""[s] by which a motion may follow its command."""
_EXCITE = 'record a minute of starts, stops, slow and fast commands, such as those of the command excite'


class Lack(NamedTuple):
    """Missing data, the remedy, whether nothing can be identified without them, and whether twist and poses differ."""

    problem: str
    remedy: str
    is_vital: bool = False
    contradicts: bool = False

    def __str__(self) -> str:
        return f'{self.problem}: {self.remedy}'


def lacks(recordings: Sequence[Recorded], takes_velocity: bool) -> list[Lack]:
    """Return the missing data of recordings, vital ones first."""
    lacking = [*(_lacks_of_velocity if takes_velocity else _lacks_of_torque)(recordings), *_cuts(recordings)]
    if not any(one.truth for one in recordings):
        lacking.append(Lack('no pose from outside: wheel radius and separation are those of the firmware',
                            'record one as nav_msgs/msg/Odometry, and name it with --topic ground_truth:=/NAME'))
    return sorted(lacking, key=lambda lack: not lack.is_vital)


def _cuts(recordings: Sequence[Recorded]) -> Iterator[Lack]:
    for recording in recordings:
        for topic in ('odom', 'cmd_vel', 'joint_states'):
            if topic in recording.clocks:
                intervals = np.diff(recording.clocks[topic].times)
                gaps = intervals[intervals > max(1.0, 20.0 / recording.clocks[topic].rate)]
                if gaps.size:
                    yield Lack(f'{recording.name}: {topic} was silent {gaps.size} times, for {gaps.max():.1f} s at the '
                               'longest, and is not used there', 'record without a break')


def _lacks_of_velocity(recordings: Sequence[Recorded]) -> Iterator[Lack]:
    held = ', '.join(sorted({topic for one in recordings for topic in one.held})) or 'nothing'
    for topic, is_there in (('cmd_vel', any(one.commands for one in recordings)),
                            ('odom', any(one.motion for one in recordings))):
        reasons = [one.unusable[topic] for one in recordings if topic in one.unusable]
        if not is_there:
            yield Lack(f'{topic} is recorded, but of no use ({reasons[0]})' if reasons else f'there is no {topic}',
                       f'record it, or name it with --topic {topic}:=/NAME; there is {held}', True)
    usable = [one for one in recordings if one.commands and one.motion]
    if not usable:
        return
    yield from _contradictions(usable)
    moves = [np.abs(one.motion.speeds[one.motion.usable]).max(axis=0, initial=0.0) for one in usable if one.motion]
    if any(one.motion.usable.any() for one in usable if one.motion) and (np.max(moves, axis=0) < STILL).all():
        yield Lack('the robot stands', _EXCITE, True)
        return
    seconds = sum(float(np.diff(one.motion.times)[one.motion.usable].sum()) for one in usable if one.motion)
    if seconds < _SHORTEST:
        yield Lack(f'commands and odometry lie beside each other for {seconds:.1f} s only',
                   f'record at least {_SHORTEST:.0f} s, better a minute', True)
    linear, angular = excited_by(usable)
    if not (linear or angular):
        yield Lack('the commands never change while odometry is recorded', _EXCITE, True)
    elif not angular:
        yield Lack('the robot drives straight ahead only: its turning does not show', f'{_EXCITE}, turns included')
    elif not linear:
        yield Lack('the robot turns on the spot only: its driving does not show',
                   f'{_EXCITE}, straight drives included')
    for n, name, unit in ((0, 'v', 'm/s'), (1, 'ω', 'rad/s')):
        if (linear, angular)[n]:
            yield from _lacks_of_a_velocity(usable, n, name, unit)


def _contradictions(recordings: Sequence[Recorded]) -> Iterator[Lack]:
    """Yield contradictions of the poses of odometry to its twist, and to the commands."""
    for n, (name, unit, least) in enumerate((('v', 'm/s', 0.3), ('ω', 'rad/s', 0.5))):
        moved, commanded = _over_windows(recordings, n, _asked)
        if np.abs(commanded).sum() > least and np.abs(moved).sum() > least:
            beside = [_over_windows(recordings, n, partial(_asked, late=late)) for late in _LATER.tolist()]
            fits = [_gain(asked, moved) for moved, asked in beside]
            against, along = (min((left for gain, left in fits if gain * sign > 0.0), default=1.0)
                              for sign in (-1.0, 1.0))
            if against < min(along, _MISSED):
                yield Lack(f'{name} of odometry moves against the command: wheels or encoders are swapped, or axes '
                           'point down (NED)', 'mend the sign in the driver, and record again', True)
        moved, told = _over_windows(recordings, n, _told)
        moves, tells = np.abs(moved).sum() > least, np.abs(told).sum() > least
        if moves and not told.any():
            yield Lack(f'{name} of the twist of odom is always zero while its poses move',
                       'let the driver publish it: nodes read speeds from it', contradicts=True)
        elif tells and not np.abs(moved).sum() > 0.01 * np.abs(told).sum():
            yield Lack(f'the poses of odom stay while {name} of its twist moves',
                       'let the driver integrate its odometry, and record again', True, True)
        elif moves and tells:
            gain, _ = _gain(moved, told)
            left = np.sqrt(np.mean((moved - told)**2))
            if left > _MISSED * max(np.sqrt(np.mean(moved**2)), np.sqrt(np.mean(told**2))):
                yield Lack(f'{name} of the twist of odom is {_unlike(gain, unit)} that of its poses',
                           'mend the driver, whose twist the nodes read', contradicts=True)


def _unlike(gain: float, unit: str) -> str:
    """Describe the ratio of a twist to the motion of poses."""
    for ratio, words in ((3.6, 'in km/h, 3.6 times'), (np.degrees(1.0), 'in degrees/s, 57.3 times'),
                         (-1.0, 'of the opposite sign, -1 times')):
        if abs(gain / ratio - 1.0) < 0.1 and (ratio < 0.0 or words.startswith('in km/h') == (unit == 'm/s')):
            return words
    return f'{gain:.2g} times'


def _gain(motion: Floats, other: Floats) -> tuple[float, float]:
    """Return the least-squares ratio of one motion to another, and the share that it leaves."""
    gain = float(motion @ other) / (float(motion @ motion) + 1e-12)
    return gain, float(np.sqrt(((other - gain * motion)**2).sum() / ((other**2).sum() + 1e-12)))


def _over_windows(
    recordings: Sequence[Recorded], n: int, other: Callable[[Recorded], Floats]
) -> tuple[Floats, Floats]:
    """Return the motion of poses in windows of a second, and another motion beside it: v or ω."""
    rows = []
    for recording in recordings:
        assert recording.motion  # noqa: S101 (for mypy: checked by the caller)
        number = np.floor(recording.motion.times[:-1] - recording.motion.times[0]).astype(int)
        kept = recording.motion.usable
        rows.append([np.bincount(number[kept], values[kept, n])
                     for values in (recording.motion.moved, other(recording))])
    moved, beside = (np.concatenate(column) for column in zip(*rows, strict=True))
    return moved, beside


def _told(recording: Recorded) -> Floats:
    """Return the motion by the twist of odometry between its messages."""
    assert recording.motion  # noqa: S101 (for mypy: checked by the caller)
    assert recording.twist is not None  # noqa: S101 (for mypy, too)
    moved: Floats = 0.5 * (recording.twist[1:] + recording.twist[:-1]) * np.diff(recording.motion.times)[:, None]
    return moved


def _asked(recording: Recorded, late: float = 0.0) -> Floats:
    """Return the motion that commands ask for between messages of odometry, so much later [s]."""
    assert recording.motion  # noqa: S101 (for mypy: checked by the caller)
    assert recording.commands  # noqa: S101 (for mypy, too)
    commands = recording.commands
    way = np.concatenate([np.zeros((1, 2)), np.cumsum(commands.values[:-1] * np.diff(commands.times)[:, None], axis=0)])
    times = recording.motion.times - late
    return np.diff(np.column_stack([np.interp(times, commands.times, way[:, n]) for n in (0, 1)]), axis=0)


def _lacks_of_a_velocity(recordings: Sequence[Recorded], n: int, name: str, unit: str) -> Iterator[Lack]:
    commands = np.concatenate([one.commands.values[:, n] for one in recordings if one.commands])
    largest = float(np.abs(commands).max())
    small = np.abs(commands[commands != 0.0])
    if small.min(initial=np.inf) > 0.1 * largest:
        yield Lack(f'no command of {name} lies between 0 and {small.min(initial=largest):.2g} {unit}: a dead zone '
                   'would not show', 'record slow commands, too')
    if (commands < 0.0).all() or (commands > 0.0).all() or not (commands == 0.0).any():
        yield Lack(f'{name} is never commanded to be zero: the braking does not show', 'record starts and stops')


def _lacks_of_torque(recordings: Sequence[Recorded]) -> Iterator[Lack]:
    if not any(one.wheels for one in recordings):
        yield Lack('there is no joint_states', 'record it, or name it with --topic joint_states:=/NAME', True)
        return
    with_efforts = [one for one in recordings if one.torques and np.isfinite(one.torques.values).any()]
    if not with_efforts:
        yield Lack('joint_states has no effort, which is unknown then and not zero',
                   "record the motors' torques as its effort; a robot that takes cmd_vel is identified by cmd_vel and "
                   'odom, with -p plant.drive:=velocity', True)
        return
    turned = [np.abs(one.wheels.moved).sum(axis=0) for one in with_efforts if one.wheels]
    if np.max(turned) < 0.5:
        yield Lack('the robot stands', _EXCITE, True)
        return
    usable = sum(float(np.diff(one.wheels.times)[one.wheels.usable].sum()) for one in with_efforts if one.wheels)
    if usable < 0.5 * _SHORTEST:
        yield Lack(f'efforts are known for {usable:.1f} s only', 'record them with each message, for a minute', True)
    if not turns(with_efforts):
        yield Lack('the robot drives straight ahead only: its inertia does not show', f'{_EXCITE}, turns included')


def turns(recordings: Sequence[Recorded]) -> bool:
    """Return whether the speeds of the wheels differ enough to tell the inertia."""
    both = np.concatenate([one.wheels.speeds[one.wheels.usable] for one in recordings if one.wheels])
    return float(np.ptp(both[:, 0] - both[:, 1])) >= 0.05 * float(np.ptp(both, axis=0).max())


def not_seen(fit: BaseFit, recordings: Sequence[Recorded]) -> list[str]:
    """Describe the limits and dead zones that do not show, and the range without them."""
    words = []
    for n, (name, unit) in enumerate((('v', 'm/s'), ('ω', 'rad/s'))):
        if not fit.excited[n]:
            continue
        fastest = max(float(np.abs(one.motion.speeds[one.motion.usable, n]).max()) for one in recordings if one.motion)
        absent = [text for limit, text in (('max_speed', 'limit of it'), ('max_acceleration', 'limit of its change'),
                                           ('dead_zone', 'dead zone'))
                  if f'base.{limit}[{n}]' not in (*fit.estimate.names, *fit.zones)]
        if absent:
            words.append(f'up to {fastest:.2g} {unit} of {name} no {", and no ".join(absent)} shows')
    return words


def second_lags(fit: BaseFit) -> list[str]:
    """Describe the second lags that the plant lacks."""
    return [f'{name} follows with two lags, of {first:.3g} and {second:.3g} s: the lag and the dead time written stand '
            'in for them' for name, (first, second) in fit.second_lags.items()]


def missing_in_model(
    estimated: Estimate, predictions: Sequence[Prediction], inputs: Sequence[tuple[str, Floats]]
) -> list[str]:
    """
    Describe the missing parts of a model by its residuals.

    Parameters
    ----------
    estimated : Estimate
        With residuals that would be white under the right model and noise.
    predictions : sequence of Prediction
        Recorded and modelled motion; residuals that are small compared with it are not reported.
    inputs : sequence of (str, array of float)
        Names of the robot's inputs, and their values beside the residuals, shape (n, 2) each.
    """
    white = estimated.whitened - estimated.whitened.mean(axis=0)
    count = white.shape[0]
    chance = max(_NOTABLE, _SURE / np.sqrt(count))
    measured = np.concatenate([one.measured for one in predictions])
    left = np.nanmean((measured - np.concatenate([one.modelled for one in predictions])) ** 2, axis=0)
    slight = left < _SLIGHT**2 * np.nanmean(measured**2, axis=0)
    words = []
    for n, output in enumerate(('v', 'ω')):
        if slight[n]:
            continue
        own = _correlations(white[:, n], white[:, n])[1:]
        if np.abs(own).max() > chance:
            lag = int(np.abs(own).argmax()) + 1
            words.append(f'residuals of {output} are correlated over {lag} sample{"s" * (lag > 1)} '
                         f'({own[lag - 1]:+.2f}): a disturbance, or dynamics that the model does not have')
        for name, values in inputs:
            changes = np.diff(values, axis=0, prepend=values[:1])
            for m, component in enumerate(('v', 'ω')):
                beside = _correlations(white[:, n], changes[:, m])
                if np.abs(beside).max() > chance:
                    lag = int(np.abs(beside).argmax())
                    words.append(f'residuals of {output} follow {name} of {component}, most after {lag} samples '
                                 f'(correlation {beside[lag]:+.2f}): the response has a part that the model '
                                 'lacks, such as a second lag, a filter, a ramp, or a base that takes commands at its '
                                 'own rate')
    return words


def _correlations(signal: Floats, before: Floats) -> Floats:
    """Return the correlations of a signal with another one, by the lag in samples."""
    other = before - before.mean()
    size = float(np.sqrt((signal**2).sum() * (other**2).sum())) + 1e-300
    most = min(_LARGEST_LAG, signal.size - 1)
    return np.array([float(signal[lag:] @ other[:other.size - lag]) / size for lag in range(most)])
