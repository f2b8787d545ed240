"""The timing of a run over DDS: how messages came, by the recorder's clock."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from mobile_robot_control.recording.gaps import find_gaps
from mobile_robot_control.reporting.lines import Floats, Line
from mobile_robot_control.reporting.page import html_table
from mobile_robot_control.reporting.panels import Named, Panel, over_time
from mobile_robot_control.reporting.series import Series
from mobile_robot_control.topics import ANSWERS, LOOP_TOPICS


def timed(series: Series) -> bool:
    """
    Say whether a run was recorded over DDS.

    Parameters
    ----------
    series : Series
        Of the run.

    Returns
    -------
    bool
        True if messages have times of receipt.

    """
    return any(signal.received for signal in series.signals.values())


def _received(series: Series, topic: str) -> Floats:
    signal = series.signals[topic]
    received: Floats = np.frombuffer(signal.received, dtype=np.int64) / 1e9
    return received


def intervals(series: Series, topic: str) -> Line:
    """
    Give the wall time between a message and the one before it.

    Parameters
    ----------
    series : Series
        Of a run over DDS.
    topic : str
        One of the loop.

    Returns
    -------
    Line
        [ms] over the run's time.

    """
    return Line(series.time(topic)[1:], 1e3 * np.diff(_received(series, topic)))


def latency(series: Series, question: str, answer: str) -> Line:
    """
    Give the wall time from a message to its answer, as the recorder heard them.

    Parameters
    ----------
    series : Series
        Of a run over DDS.
    question, answer : str
        Topics.

    Returns
    -------
    Line
        [ms] at the answers' times: in lockstep to the answer of the same stamp, on the wall clock the age of the
        newest question when the answer came.

    """
    asked, answered = _received(series, question), _received(series, answer)
    if not asked.size or not answered.size:
        return Line(np.zeros(0), np.zeros(0))
    ours, theirs = (np.frombuffer(series.signals[topic].stamps, dtype=np.int64) for topic in (question, answer))
    place = np.searchsorted(asked, answered) - 1 if series.origin else np.searchsorted(ours, theirs)
    place = np.clip(place, 0, asked.size - 1)
    fits = asked[place] <= answered if series.origin else ours[place] == theirs
    return Line(series.time(answer)[fits], 1e3 * (answered[fits] - asked[place][fits]))


class Quantiles(NamedTuple):
    """Median, 99 % quantile and maximum of a number of values."""

    median: float
    high: float
    largest: float


def quantiles(values: Floats) -> Quantiles | None:
    """
    Sum up values.

    Parameters
    ----------
    values : array, shape (n,)
        Any unit.

    Returns
    -------
    Spread or None
        None for no values.

    """
    if not values.size:
        return None
    return Quantiles(float(np.median(values)), float(np.quantile(values, 0.99)), float(values.max()))


def draw_intervals(runs: Sequence[Named]) -> Figure:
    """
    Draw the wall time between messages.

    Parameters
    ----------
    runs : sequence of Named
        Over DDS.

    Returns
    -------
    Figure
        Of the fast and of the slow loop.

    """
    return over_time([
        Panel('joint_states [ms]', lambda series: intervals(series, 'joint_states')),
        Panel('odom [ms]', lambda series: intervals(series, 'odom')),
    ], runs)


def draw_latency(runs: Sequence[Named]) -> Figure:
    """
    Draw how long answers took.

    Parameters
    ----------
    runs : sequence of Named
        Over DDS.

    Returns
    -------
    Figure
        Of both loops.

    """
    return over_time([
        Panel('odom → cmd_vel [ms]', lambda series: latency(series, 'odom', 'cmd_vel')),
        Panel('joint_states →\nwheel_torques [ms]', lambda series: latency(series, 'joint_states', 'wheel_torques')),
    ], runs)


def timing_table(series: Series) -> str:
    """
    Give the timing of a run in numbers.

    Parameters
    ----------
    series : Series
        Of a run over DDS.

    Returns
    -------
    str
        HTML: each topic's intervals, each answer's latency, and the gaps by stamp.

    """
    rows = []
    for topic in LOOP_TOPICS:
        count = len(series.signals[topic].stamps)
        silences = len(find_gaps(series.signals[topic].stamps, series.origin))
        rows.append([f'<code>{topic}</code>', str(count), *_written(quantiles(intervals(series, topic).value)),
                     str(silences)])
    between = html_table(['every', 'messages', 'median', '99 %', 'longest', 'gaps by stamp'], rows)
    answers = html_table(['from question to answer', 'median', '99 %', 'longest'], [
        [f'<code>{question}</code> → <code>{answer}</code>',
         *_written(quantiles(latency(series, question, answer).value))] for question, answer in ANSWERS
    ])
    return between + answers


def _written(found: Quantiles | None) -> list[str]:
    return ['–'] * 3 if found is None else [f'{value:.3g} ms' for value in found]
