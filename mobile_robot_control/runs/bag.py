"""The reader of bags, whole or damaged, by any names of topics: it keeps numbers in memory, never messages."""

import re
from bisect import bisect_right
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.messages.bag_files import BagFiles
from mobile_robot_control.messages.bag_messages import RESET, BagError, Change, Message, ProgressCallback, read_change
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import (
    RefusedMessageError,
    read_or_refuse,
    read_plain_twist,
    serialised_stamp,
)
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.parameters.requests import Reader
from mobile_robot_control.quantities import NANOSECONDS
from mobile_robot_control.runs.columns import READ
from mobile_robot_control.runs.errors import with_errors
from mobile_robot_control.runs.samples import LastRun, Messages, samples_of
from mobile_robot_control.runs.series import Series, Signal, describe_gaps, empty_signal
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import EVENTS, GROUND_TRUTH, PLAIN_TWIST, RECORDED_TOPICS, RUN_TOPICS

NAMES = tuple(RUN_TOPICS)
"""Topics sought in a bag."""


def held_topics(path: Path) -> dict[str, str]:
    """Return the types of all topics of a bag by their absolute names; raise BagError if it is no bag."""
    bag = BagFiles(path, lambda *_: None)
    for _ in bag.messages(lambda _: False):
        pass
    return bag.topics


def choose_topics(namespace: str, topics: Mapping[str, str], held: Collection[str]) -> tuple[dict[str, str], list[str]]:
    """
    Choose the topics of a bag.

    Parameters
    ----------
    namespace : str
        Of the nodes; relative names are in it.
    topics : mapping of str to str
        The other names of some of NAMES.
    held : set of str
        Absolute names of the bag's topics; used only with other names.

    Returns
    -------
    tuple of dict of str to str, and list of str
        The loop's name of each topic by its name in the bag, and the topics the bag lacks, in words.
    """
    prefix = namespace.rstrip('/') + '/'
    renamed: dict[str, str] = {}
    problems = []
    for name, chosen in topics.items():
        other = chosen if chosen.startswith('/') else prefix + chosen
        if other in held:
            renamed[other] = name
        else:
            instead = f'{prefix + name} is taken' if prefix + name in held else f'it holds {_listed(held)}'
            problems.append(f'--topic {name}:={chosen}: the bag has no {other}; {instead}')
    usual = {prefix + name: name for name in NAMES if name not in renamed.values()}
    # another name may be the usual one of another topic
    return usual | renamed, problems


def missing_topics(
    names: Mapping[str, str], silent: Collection[str], held: Mapping[str, str], timed: bool = True
) -> Iterator[str]:
    """Yield remedies for a bag without odometry or, for a drive in time, reference under the names sought."""
    loop = [topic for topic, name in names.items() if name not in RECORDED_TOPICS]
    if not any(topic in held for topic in loop):
        yield (f'none of the topics {", ".join(loop)}; the bag holds {_listed(held)}: name the robot with --namespace, '
               'or its topics with --topic odom:=/NAME')
    elif lacking := [name for name in ('odom', 'reference')[:1 + timed] if name in silent]:
        kind = _KINDS[lacking[0]][0]
        free = [topic for topic, its in held.items() if its in (kind, '') and names.get(topic, '') in ('', *silent)]
        yield (f'the bag holds {_listed(free)} of type {kind}: where one of them is {" or ".join(lacking)}, add '
               f'--topic {lacking[0]}:=/NAME' if free else
               f'the bag holds no other topic of type {kind}: record {" and ".join(lacking)} as such')


def _listed(held: Collection[str]) -> str:
    return shortened(', '.join(sorted(map(str, held)))) or 'nothing'


_AGREE = NANOSECONDS
"""[ns]: stamps nearer to their receipt than this come from the recorder's clock."""


def stamped_by_receipt(plain: Signal, clock: Signal) -> Signal:
    """
    Convert messages that were stamped on receipt to the clock of another topic.

    Parameters
    ----------
    plain : Signal
        Its stamps are the times of receipt [ns].
    clock : Signal
        For example odometry, with stamps and times of receipt.

    Returns
    -------
    Signal
        Unchanged if the clock's stamps are wall times of the same clock. If they are simulated time, or come from a
        computer with a wrong clock, each receipt is interpolated on that clock, between the receipts of two of its
        messages; messages received before the first or after the last of them are left out.
    """
    if not clock.received.size or abs(np.median(clock.received - clock.stamps)) < _AGREE:
        return plain
    # Python's integers: products of times in ns exceed 64 bits
    pairs = sorted(zip(clock.received.tolist(), clock.stamps.tolist(), strict=True))
    times = [received for received, _ in pairs]
    kept: list[int] = []
    stamps: list[int] = []
    for n, received in enumerate(plain.received.tolist()):
        after = bisect_right(times, received)
        if 0 < after < len(pairs):
            (begun, first), (ended, last) = pairs[after - 1], pairs[after]
            stamp = first + (last - first) * (received - begun) // (ended - begun)
            if not stamps or stamp > stamps[-1]:
                kept.append(n)
                stamps.append(stamp)
    return Signal(np.array(stamps, np.int64), plain.received[kept], plain.values[kept])


_LATEST = 1 << 63
"""[ns]: times of receipt are stored in 64 bits."""
_KINDS = {**{name: (topic.kind,) for name, topic in RUN_TOPICS.items()},
          'cmd_vel': (RUN_TOPICS['cmd_vel'].kind, PLAIN_TWIST)}
"""Possible types of a topic."""
_EVENTS_KIND = 'diagnostic_msgs/msg/DiagnosticArray'


class Recording(NamedTuple):
    """
    A run read from a bag.

    Attributes
    ----------
    series : Series
        Its topics, repeats removed by stamp.
    changes : tuple of Change
        Events of the run, in the order of the bag.
    problems : tuple of str
        Missing parts, in words; empty for a complete run.
    """

    series: Series
    changes: tuple[Change, ...]
    problems: tuple[str, ...]

    @property
    def samples(self) -> list[Sample]:
        """All samples in order of time; `samples_of` yields the same one by one."""
        return list(samples_of(with_errors(self.series, exact=False)))


class _Reading:
    """Collects the messages of a run."""

    def __init__(self, any_frame: bool) -> None:
        self._any_frame = any_frame
        self._messages = Messages()
        self._changes: dict[bytes, Change] = {}
        self._left_out: Counter[str] = Counter()
        self._frames: dict[str, str] = {}
        self._found: dict[str, str] = {}
        self._without_stamp = False

    def take_message(self, name: str, message: Message) -> None:
        """Add one message of a topic; count an unusable one by its reason."""
        try:
            stamp, values = self._read(name, *message[1:])
        except RefusedMessageError as refusal:
            # the first of each kind stands for all
            reason = self._found.setdefault(f'{message.topic}: {refusal.reason}', f'{message.topic}: {refusal}')
            self._left_out[reason] += 1
        else:
            self._messages.add(name, stamp, values, message.received)

    def take_event(self, message: Message) -> None:
        """Add one message of a topic with the name of our events, which may come from anyone."""
        if message.kind == _EVENTS_KIND and isinstance(message.data, bytes):
            try:
                # a recorder that starts again receives them all again
                self._changes[message.data] = read_change(message)
            except BagError as error:
                self._left_out[str(error)] += 1

    def changes(self) -> tuple[Change, ...]:
        """Return the events of the last run: each reset begins another one."""
        last = sum(RESET in change.values for change in self._changes.values())
        return tuple(change for change in self._changes.values() if change.run == last)

    def _read(self, name: str, kind: object, received: object, data: object) -> tuple[int, tuple[float, ...]]:
        """Return stamp and numbers of a message; raise RefusedMessageError if it is unusable."""
        if kind not in _KINDS[name]:
            raise RefusedMessageError(f'is of type {shortened(str(kind), 60)}, not {" or ".join(_KINDS[name])}')
        if not (isinstance(received, int) and 0 <= received < _LATEST):
            raise RefusedMessageError('received at no possible time', f'{received} ns')
        if not isinstance(data, bytes):
            raise RefusedMessageError('not readable', f'{type(data).__name__} instead of bytes')
        if kind == PLAIN_TWIST:
            self._without_stamp = True
            return received, read_or_refuse(kind, (partial(deserialise, kind), read_plain_twist), data)
        stamp = serialised_stamp(data)
        return stamp, read_or_refuse(kind, (partial(deserialise, kind), partial(self._numbers, name)), data)

    def _numbers(self, name: str, message: Any) -> tuple[float, ...]:
        """Return the columns of a message, and note the frame of its topic."""
        self._frames.setdefault(name, message.header.frame_id)
        return READ[name](message)

    def run(self) -> tuple[Series, list[str]]:
        """Return the collected run, and the unusable messages, in words."""
        last = self._messages.last_run()
        signals = last.signals
        received = {*last.unstamped, *(['cmd_vel'] if self._without_stamp else [])}
        clock = next((one for name, one in signals.items() if name not in received and one.received.size), None)
        for name in received:
            signals[name] = stamped_by_receipt(
                signals[name], clock if clock and 'odom' in received else signals['odom'])
        if GROUND_TRUTH in self._in_other_frames():
            signals[GROUND_TRUTH] = empty_signal(GROUND_TRUTH)
        return Series(signals), [*self._problems(last)]

    def _problems(self, last: LastRun) -> Iterator[str]:
        """Yield the unusable messages, in words."""
        for reason, count in self._left_out.items():
            yield f'{count} messages left out: {reason}'
        for name, count in last.contradicting.items():
            yield (f'{count} messages on {name} carry the stamp of the one before and other values, as of a second '
                   f'publisher; the first of each stamp is taken: record one robot alone, or name its topic with '
                   f'--topic {name}:=/NAME')
        for name in last.unstamped:
            yield f'all stamps of {name} are 0: its messages have the times of their receipt'
        if last.disordered:
            yield f'{last.disordered} messages came after a later stamp of their topic'
        if last.earlier_runs:
            yield f'{last.earlier_runs} earlier runs left out; the last one is taken'
        for name in self._in_other_frames():
            yield (f"{name} is in the frame '{shortened(self._frames[name], 60)}', odom in "
                   f"'{shortened(self._frames['odom'], 60)}': "
                   + ('it is left out' if name == GROUND_TRUTH else 'errors between them mean nothing'))

    def _in_other_frames(self) -> list[str]:
        """Return the topics with poses in another frame than those of odometry."""
        odom = '' if self._any_frame else self._frames.get('odom', '')
        return [name for name in ('reference', GROUND_TRUTH) if odom and self._frames.get(name, '') not in ('', odom)]


class Contents(NamedTuple):
    """
    Topics of the loop as in a bag, whether they form a run or not.

    Attributes
    ----------
    series : Series
        Repeats removed by stamp.
    changes : tuple of Change
        Events, in the order of the bag.
    problems : list of str
        Read errors and unusable messages, in words.
    names : dict of str to str
        The loop's name of each topic by the name sought.
    held : dict of str to str
        The types of all topics of the bag, by their names.
    """

    series: Series
    changes: tuple[Change, ...]
    problems: list[str]
    names: dict[str, str]
    held: dict[str, str]


def read_contents(
    path: Path, namespace: str = '/', progress: ProgressCallback = lambda *_: None,
    topics: Mapping[str, str] | None = None, any_frame: bool = False,
) -> Contents:
    """
    Read the last run of a bag as `read_bag` does, complete or not.

    With `any_frame` poses may be in different frames.
    """
    names, problems = choose_topics(namespace, topics or {}, held_topics(path) if topics else set())
    bag, reading = BagFiles(path, progress), _Reading(any_frame)
    events = f'{namespace.rstrip("/")}/{EVENTS}'
    for message in bag.messages({*names, events}.__contains__):
        if message.topic in names:
            reading.take_message(names[message.topic], message)
        else:
            reading.take_event(message)
    series, faults = reading.run()
    return Contents(series, reading.changes(), [*problems, *bag.problems, *faults], names, bag.topics)


def read_bag(
    path: Path, namespace: str = '/', progress: ProgressCallback = lambda *_: None,
    topics: Mapping[str, str] | None = None, partly: bool = False, timed: bool = True,
) -> Recording:
    """
    Read a run from a bag.

    Parameters
    ----------
    path : Path
        The bag's folder, or one file of it; nothing is changed.
    namespace : str
        Of the nodes.
    progress : callable
        Called with the progress of the reading.
    topics : mapping of str to str
        Other names of topics of the loop, or of `ground_truth`, in the bag; if the bag has no topic of that name, the
        usual one is used, with a report.
    partly : bool
        Whether the recording covers only a part of the run: time then starts with that part.
    timed : bool
        Whether a reference in time is wanted, so that its lack is a problem.

    Returns
    -------
    Recording
        The last run in the bag, and its missing parts. A truncated bag is read up to its end.

    Raises
    ------
    BagError
        If the path is no readable bag.
    """
    series, changes, problems, names, held = read_contents(path, namespace, progress, topics)
    if partly:
        series, begun = series.begun_when_recorded()
        changes = tuple(change._replace(stamp=change.stamp - begun) for change in changes)
    silent = [topic for topic in series.signals if not series.has(topic)]
    return Recording(series, changes, (*problems, *missing_topics(names, silent, held, timed), *describe_gaps(series)))


_TOPIC = re.compile(r'/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*', re.ASCII)


def _read_topic(value: Any) -> tuple[str, str]:
    """Read NAME:=TOPIC, or a pair of them."""
    name, separator, topic = value.partition(':=') if isinstance(value, str) else (value[0], ':=', value[1])
    if not separator:
        raise ValueError('write NAME:=TOPIC, such as odom:=/base/odom')
    if name not in NAMES:
        raise ValueError(f"'{name}' is no topic of the loop; take one of {', '.join(NAMES)}")
    if not _TOPIC.fullmatch(topic):
        raise ValueError(f"'{topic}' is no name of a topic; write one such as /base/odom")
    return name, topic


Topics = Annotated[tuple[tuple[str, str], ...], Field(
    '', 'name of a loop topic, or of ground_truth, on your robot or in your bags'),
    Reader(_read_topic, 'NAME:=TOPIC', again=True, example='odom:=/base/odom')]
"""The option --topic."""


def topic_names(pairs: Sequence[tuple[str, str]]) -> dict[str, str]:
    """Return topic names in a bag by those of the loop; raise ParameterError if one occurs twice."""
    chosen: dict[str, str] = {}
    for name, topic in pairs:
        if chosen.get(name, topic) != topic:
            raise ParameterError([f"--topic '{name}:={topic}': {name} is {chosen[name]} already; name each topic once"])
        if topic in [other for known, other in chosen.items() if known != name]:
            raise ParameterError([f"--topic '{name}:={topic}': {topic} is taken already; name each topic once"])
        chosen[name] = topic
    return chosen
