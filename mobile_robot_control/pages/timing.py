"""The timing of a run over DDS: intervals and latencies by the wall clock of the recorder."""

from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.lines import Floats, Line
from mobile_robot_control.pages.page import html_table
from mobile_robot_control.runs.gaps import find_gaps
from mobile_robot_control.runs.run_figures import PanelOf, RunFigure
from mobile_robot_control.runs.series import Series
from mobile_robot_control.topics import LOOP_TOPICS, LOOPS


def timed(series: Series) -> bool:
    """Return whether a run was recorded over DDS, with times of receipt."""
    return any(signal.received.size for signal in series.signals.values())


def _received(series: Series, topic: str) -> Floats:
    """Return the wall times of receipt of a topic's messages [s]."""
    received: Floats = series.signals[topic].received / 1e9
    return received


def intervals(series: Series, topic: str) -> Line:
    """Return the wall time between consecutive messages of a run over DDS [ms]; empty if not recorded."""
    between = 1e3 * np.diff(_received(series, topic))
    return Line(series.time(topic)[1:1 + between.size], between)


def intervals_in_motion(series: Series, topic: str) -> Line:
    """Return the intervals [ms] except that after stamp 0, where an experiment waits until every topic is recorded."""
    every = intervals(series, topic)
    moves = series.signals[topic].stamps[:every.time.size] > 0
    return Line(every.time[moves], every.value[moves])


def latency(series: Series, question: str, answer: str) -> Line:
    """
    Return the wall time between the receipt of a message and of its answer [ms], at the answer's time.

    In lockstep it is the answer with the same stamp; on the wall clock the latency is the age of the newest question at
    the receipt of the answer.
    """
    asked, answered = _received(series, question), _received(series, answer)
    if not asked.size or not answered.size:
        return Line(np.zeros(0), np.zeros(0))
    questions, answers = (series.signals[topic].stamps for topic in (question, answer))
    place = np.searchsorted(asked, answered) - 1 if series.origin else np.searchsorted(questions, answers)
    place = np.clip(place, 0, asked.size - 1)
    fits = asked[place] <= answered if series.origin else questions[place] == answers
    return Line(series.time(answer)[fits], 1e3 * (answered[fits] - asked[place][fits]))


class Quantiles(NamedTuple):
    """Median, 99 % quantile and maximum of some values."""

    median: float
    high: float
    largest: float


def quantiles(values: Floats) -> Quantiles | None:
    """Return the quantiles of values of shape (n,); None if there are none."""
    if not values.size:
        return None
    return Quantiles(float(np.median(values)), float(np.quantile(values, 0.99)), float(values.max()))


TIMING_FIGURES = (
    RunFigure('intervals', 'Between messages', 'Wall time from one message to the next, as the recorder '
              'received them, without the wait after the messages of stamp 0, in which an experiment is paused '
              'until every topic is recorded. The table includes that wait.', (
                  PanelOf('joint_states', 'ms', lambda series: intervals_in_motion(series, 'joint_states')),
                  PanelOf('odom', 'ms', lambda series: intervals_in_motion(series, 'odom')))),
    RunFigure('latency', 'From question to answer', 'Wall time until the answer to a message was received.', (
        PanelOf('odom → cmd_vel', 'ms', lambda series: latency(series, 'odom', 'cmd_vel')),
        PanelOf('joint_states →\nwheel_torques', 'ms', lambda series: latency(series, 'joint_states', 'wheel_torques')),
    )),
)


def timing_table(series: Series) -> str:
    """Return the timing of a run over DDS as HTML: intervals and gaps of recorded topics, latency of answers."""
    rows = []
    for topic in filter(lambda topic: series.signals[topic].received.size, LOOP_TOPICS):
        stamps = series.signals[topic].stamps
        rows.append([f'<code>{topic}</code>', str(len(stamps)), *_written(quantiles(intervals(series, topic).value)),
                     str(len(find_gaps(stamps, series.origin)))])
    between = html_table(['every', 'messages', 'median', '99 %', 'longest', 'gaps by stamp'], rows)
    answers = [[f'<code>{question}</code> → <code>{answer}</code>',
                *_written(quantiles(latency(series, question, answer).value))]
               for question, answer in LOOPS['torque'].answers
               if series.signals[question].received.size and series.signals[answer].received.size]
    return between + (html_table(['from question to answer', 'median', '99 %', 'longest'], answers) if answers else '')


def _written(found: Quantiles | None) -> list[str]:
    """Return quantiles [ms] as the cells of a table."""
    return ['–'] * 3 if found is None else [f'{value:.3g} ms' for value in found]
