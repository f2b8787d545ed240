"""A recording of a robot, prepared for identification: its clocks, its commands, and its motion between messages."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.messages.bag_messages import ProgressCallback
from mobile_robot_control.quantities import NANOSECONDS
from mobile_robot_control.runs.bag import Contents, read_contents
from mobile_robot_control.runs.columns import COLUMNS
from mobile_robot_control.runs.series import Signal
from mobile_robot_control.topics import GROUND_TRUTH

_A_DAY = 86400.0
_WINDOWS = 20
_FEWEST = 25
"""Messages of a window in which the fastest one is sought."""
_LATE = 0.98
"""Quantile of the lateness that counts as its largest."""
SAMPLED, SENT = 'sampled', 'sent'


class Clock(NamedTuple):
    """
    The stamps of a topic, on the recorder's clock.

    Attributes
    ----------
    times : array of float, shape (n,)
        Of the messages: their stamps, plus the delay of the fastest messages [s].
    floor : float
        That delay, with the offset between both clocks [s].
    rate : float
        Of the messages sent, including lost ones [Hz].
    jitter : float
        Largest delay of messages, relative to the fastest ones [s].
    lost : float
        Share of missing messages, at the usual rate.
    stamped : str
        SAMPLED, SENT, or '' if unknown.
    """

    times: Floats
    floor: float
    rate: float
    jitter: float
    lost: float
    stamped: str


def is_wall(signal: Signal) -> bool:
    """Return whether stamps come from a wall clock, near the time of receipt."""
    return bool(signal.received.size and abs(np.median(signal.received - signal.stamps)) < 1e9 * _A_DAY)


def read_clock(signal: Signal, origin: int, on_receipt: bool) -> Clock:
    """
    Return the clock of a topic with at least two messages.

    Parameters
    ----------
    signal : Signal
        With stamps, and times of receipt.
    origin : int
        Stamp of t = 0 [ns].
    on_receipt : bool
        Whether times are converted to the recorder's clock; stamps of simulated time are not.
    """
    stamps = (signal.stamps - origin) / 1e9
    intervals = np.diff(stamps)
    usual = float(np.median(intervals))
    sent = max(1.0, float(np.round(intervals / usual).sum()))
    lost, rate = 1.0 - intervals.size / sent, sent / float(stamps[-1] - stamps[0])
    if not on_receipt:
        return Clock(stamps, 0.0, rate, 0.0, max(0.0, lost), '')
    took = (signal.received - signal.stamps) / 1e9
    floor = _floor(stamps, took)
    late = took - floor
    received = np.diff(signal.received) / 1e9
    stamps_vary, receipts_vary = (float(np.percentile(np.abs(one - usual), 80.0)) for one in (intervals, received))
    stamped = ''
    if max(stamps_vary, receipts_vary) > 0.02 * usual:
        stamped = SAMPLED if stamps_vary < 0.5 * receipts_vary else SENT if float(
            np.quantile(late, _LATE)) < 0.5 * stamps_vary else ''
    return Clock(stamps + floor, float(np.median(floor)), rate, float(np.quantile(late, _LATE)),
                 max(0.0, lost), stamped)


def _floor(stamps: Floats, took: Floats) -> Floats:
    """Return a lower envelope of the delays of messages [s]: the fastest of each window, so that clocks may drift."""
    count = min(_WINDOWS, stamps.size // _FEWEST)
    if count < 5:
        return np.full(stamps.size, took.min())
    parts = np.array_split(np.arange(stamps.size), count)
    fastest = np.array([part[took[part].argmin()] for part in parts])
    slope, height = np.polyfit(stamps[fastest], took[fastest], 1)
    line: Floats = height + slope * stamps
    # below all but a few
    line += np.quantile(took - line, 0.01)
    return line


_LONGEST = 5.0
"""Usual intervals: over longer ones the robot's motion is unknown."""
_SETTLING = 2.0
"""[s] after a start in motion, or after a gap, in which the initial velocity of a model is unknown."""
_SILENCE = 0.5
"""[s] without a command: a gap."""
_STEP = 0.1
"""Share of the range of commands that counts as a step."""
STILL = 1e-3
"""[m/s], [rad/s]: a slower robot stands."""
_BREAK = 60.0
"""[s]: a longer silence of all topics, or a larger step of a clock, divides a recording."""
_BEYOND = 3.0
"""Times the usual largest speed: a faster jump of odometry is no motion."""
_FEW = 2
"""So few messages of a topic tell nothing."""
Mask = NDArray[np.bool_]


class RecordedMotion(NamedTuple):
    """
    The motion of a robot between its messages.

    Attributes
    ----------
    times : array of float, shape (n + 1,)
        Of the messages [s].
    moved : array of float, shape (n, 2)
        Distance [m] and turn [rad]; or the angles of the right and the left wheel [rad].
    usable : array of bool, shape (n,)
        The intervals that are compared with a model.
    """

    times: Floats
    moved: Floats
    usable: Mask

    @property
    def speeds(self) -> Floats:
        """Mean velocities between the messages, shape (n, 2) [1/s]."""
        found: Floats = self.moved / np.diff(self.times)[:, None]
        return found


class Commands(NamedTuple):
    """Commands [m/s, rad/s] or torques of the right and the left wheel [N m], each valid from its time [s] on."""

    times: Floats
    values: Floats


class Poses(NamedTuple):
    """Poses x, y [m] and heading [rad], shape (n, 3), at times [s]."""

    times: Floats
    values: Floats


class Recorded(NamedTuple):
    """
    One recording.

    Attributes
    ----------
    name : str
        Of the bag.
    commands : Commands or None
        Of cmd_vel.
    odometry : Poses or None
        As recorded.
    motion : RecordedMotion or None
        Of odometry.
    truth : Poses or None
        From outside.
    torques : Commands or None
        Efforts of joint_states; each applied up to its time, nan if unknown.
    requests : Commands or None
        Of wheel_torques.
    wheels : RecordedMotion or None
        Of joint_states.
    clocks : dict of str to Clock
        By topic.
    problems : tuple of str
        Read errors, in words.
    held : tuple of str
        Topics of the bag.
    unusable : dict of str to str
        The reason, in words, for each topic of the loop that the bag holds without use.
    twist : array of float, shape (n, 2), or None
        Of odometry, beside its poses [m/s], [rad/s].
    """

    name: str
    commands: Commands | None
    odometry: Poses | None
    motion: RecordedMotion | None
    truth: Poses | None
    torques: Commands | None
    requests: Commands | None
    wheels: RecordedMotion | None
    clocks: dict[str, Clock]
    problems: tuple[str, ...]
    held: tuple[str, ...]
    unusable: dict[str, str]
    twist: Floats | None = None


def read_recorded(
    path: Path, namespace: str = '/', topics: Mapping[str, str] | None = None,
    progress: ProgressCallback = lambda *_: None,
) -> list[Recorded]:
    """
    Read a recording from a bag, or the parts of one with long breaks.

    Raises
    ------
    BagError
        If it is not a bag that can be read.
    """
    return recorded_from(path.name, read_contents(path, namespace, progress, topics, any_frame=True))


def recorded_from(name: str, contents: Contents) -> list[Recorded]:
    """Make recordings from the topics of a bag: one, or one for each part between long breaks."""
    signals = {topic: contents.series.signals[topic] for topic in (
        'cmd_vel', 'odom', 'joint_states', 'wheel_torques', GROUND_TRUTH)}
    signals['odom'] = _without_repeats(signals['odom'])
    parts = _between_breaks(signals)
    problems = list(contents.problems)
    if len(parts) > 1:
        problems.append(f'there are breaks of more than {_BREAK:g} s, or steps of a clock: {len(parts)} parts are '
                        'taken, each as a recording of its own')
    unusable = {
        topic: '; '.join(problem for problem in problems if f' {sought}: ' in problem) or 'fewer than 3 messages'
        for sought, topic in contents.names.items() if sought in contents.held and signals.get(
            topic, contents.series.signals[topic]).stamps.size <= _FEW}
    about = tuple(problems), tuple(sorted(contents.held)), unusable
    return [_recording(name if n == 0 else f'{name}, part {n + 1}', part, *(about if n == 0 else ((), *about[1:])))
            for n, part in enumerate(parts)]


def _between_breaks(signals: Mapping[str, Signal]) -> list[dict[str, Signal]]:
    """Return the parts of a recording between its breaks, without those that show no motion."""
    received = np.sort(np.concatenate([signal.received for signal in signals.values()]))
    steps = [(received, np.diff(received))]
    steps += [(one.received, np.abs(np.diff(one.stamps) - np.diff(one.received))) for one in signals.values()]
    breaks = sorted(time for times, sizes in steps for time in times[1:][sizes > NANOSECONDS * _BREAK].tolist())
    places = {topic: np.digitize(signal.received, breaks) for topic, signal in signals.items()}
    parts = [{topic: Signal(*(column[places[topic] == n] for column in signal)) for topic, signal in signals.items()}
             for n in range(len(breaks) + 1)]
    return [part for part in parts if max(part[topic].stamps.size for topic in ('odom', 'joint_states')) > _FEW
            ] or [dict(signals)]


def _recording(
    name: str, signals: Mapping[str, Signal], problems: tuple[str, ...], held: tuple[str, ...],
    unusable: dict[str, str],
) -> Recorded:
    """Make one recording from its topics."""
    usable = {topic: signal for topic, signal in signals.items() if signal.stamps.size > _FEW}
    origin = min((int(signal.stamps[0]) for signal in usable.values()), default=0)
    on_receipt = all(map(is_wall, usable.values()))
    clocks = {topic: read_clock(signal, origin, on_receipt) for topic, signal in usable.items()}

    def poses(topic: str) -> Poses | None:
        return Poses(clocks[topic].times, signals[topic].values[:, :3]) if topic in clocks else None

    commands, requests = (Commands(clocks[topic].times, signals[topic].values) if topic in clocks else None
                          for topic in ('cmd_vel', 'wheel_torques'))
    odometry = poses('odom')
    motion = _motion_of(odometry, commands) if odometry else None
    torques, wheels = _wheels(signals['joint_states'], clocks['joint_states']) if 'joint_states' in clocks else (
        None, None)
    return Recorded(
        name=name, commands=commands, odometry=odometry, motion=motion, truth=poses(GROUND_TRUTH), torques=torques,
        requests=requests, wheels=wheels, clocks=clocks, problems=problems, held=held, unusable=unusable,
        twist=signals['odom'].values[:, 3:5] if odometry else None)


def _without_repeats(odom: Signal) -> Signal:
    """Return odometry without repeated samples while the robot moves."""
    values = odom.values
    repeats = (values[1:] == values[:-1]).all(axis=1) & (values[1:, 3:] != 0.0).any(axis=1)
    kept = np.concatenate([[True], ~repeats])[:values.shape[0]]
    return Signal(odom.stamps[kept], odom.received[kept] if odom.received.size else odom.received, values[kept])


def moved_between(poses: Floats) -> Floats:
    """Return distance [m] along the arc and turn [rad] between poses, shape (n, 3)."""
    turn = (np.diff(poses[:, 2]) + np.pi) % (2.0 * np.pi) - np.pi
    middle = poses[:-1, 2] + 0.5 * turn
    chord = np.diff(poses[:, 0]) * np.cos(middle) + np.diff(poses[:, 1]) * np.sin(middle)
    # an arc is longer than its chord by x / sin(x), with x half its turn
    moved: Floats = np.column_stack([chord / np.sinc(0.5 * turn / np.pi), turn])
    return moved


def _motion_of(odometry: Poses, commands: Commands | None) -> RecordedMotion:
    """Return the robot's motion by its odometry, and the intervals that can be compared with a model."""
    times, moved = odometry.times, moved_between(odometry.values)
    intervals = np.diff(times)
    speeds = np.abs(moved) / intervals[:, None]
    # a robot may stand for all but a moment of a recording
    usual = np.array([np.quantile(one[one > STILL], 0.995) if (one > STILL).any() else 0.0 for one in speeds.T])
    usable = (intervals < _LONGEST * np.median(intervals)) & (speeds <= _BEYOND * usual + 0.1).all(axis=1)
    if (speeds[:3] > 0.1 * usual + 1e-3).any():
        usable &= times[1:] > times[0] + _SETTLING
    if commands is not None:
        silent = np.flatnonzero(np.diff(commands.times) > _SILENCE)
        for begin, end in zip(commands.times[silent], commands.times[silent + 1], strict=True):
            usable &= (times[1:] < begin + _SILENCE) | (times[:-1] > end + _SETTLING)
        # a step in a gap between commands occurred at an unknown time
        intervals, steps = np.diff(commands.times), np.abs(np.diff(commands.values, axis=0))
        large = (steps > _STEP * np.ptp(commands.values, axis=0)).any(axis=1)
        for lost in np.flatnonzero((intervals > 1.5 * np.median(intervals)) & large):
            usable &= (times[1:] < commands.times[lost]) | (times[:-1] > commands.times[lost + 1] + 0.5 * _SETTLING)
        usable &= (times[:-1] > commands.times[0]) & (times[1:] < commands.times[-1] + _SILENCE)
    return RecordedMotion(times, moved, usable)


def _wheels(joints: Signal, clock: Clock) -> tuple[Commands, RecordedMotion]:
    """Return the torques and the motion of both wheels."""
    columns = {name: joints.values[:, n] for n, name in enumerate(COLUMNS['joint_states'])}
    angles, speeds, efforts = (np.column_stack([columns[f'{side}_{kind}'] for side in ('right', 'left')])
                               for kind in ('angle', 'velocity', 'effort'))
    intervals = np.diff(clock.times)
    if not np.isfinite(angles).all() or not angles.any():
        # without encoder angles, velocities count as those at the stamps
        turned = 0.5 * (speeds[1:] + speeds[:-1]) * intervals[:, None]
    else:
        turned = np.diff(angles, axis=0)
    # the effort of a message was applied since the previous message; over a longer gap it is unknown
    is_known = intervals < 1.5 / clock.rate
    applied = np.where(is_known[:, None], efforts[1:], np.nan)
    return (Commands(clock.times, np.concatenate([applied[:1], applied])),
            RecordedMotion(clock.times, turned, is_known & np.isfinite(applied).all(axis=1)))


def cut(recorded: Recorded, seconds: float) -> Recorded:
    """Return the first `seconds` of a recording's commands and motion."""
    commands, motion = recorded.commands, recorded.motion
    assert commands  # noqa: S101 (for mypy: checked by the caller)
    assert motion  # noqa: S101 (for mypy, too)
    end = motion.times[0] + seconds
    told, last = int(np.searchsorted(commands.times, end)), int(np.searchsorted(motion.times, end))
    return recorded._replace(
        commands=Commands(commands.times[:told], commands.values[:told]),
        motion=RecordedMotion(motion.times[:last], motion.moved[:last - 1], motion.usable[:last - 1]))
