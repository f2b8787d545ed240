"""The events of a run in words, and its parts, one for each law."""

import json
from typing import NamedTuple

import numpy as np

from mobile_robot_control.runs.record import Event
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.series import Series
from mobile_robot_control.system.texts import shortened

_LAW = 'controller_type'


class Segment(NamedTuple):
    """
    A part of a run with one position law.

    Attributes
    ----------
    law : str
        Its name.
    begin, end : float
        Times [s].
    rms_error, max_error : float or None
        Distance to the cart [m], as in the run's metrics; None if unknown.
    peak_torque : float or None
        Largest absolute torque of either wheel [N m].

    """

    law: str
    begin: float
    end: float
    rms_error: float | None
    max_error: float | None
    peak_torque: float | None


def event_text(event: Event) -> str:
    """Return an event as 'backstepping.p = 1.5'."""
    return shortened(', '.join(f'{name} = {json.dumps(value)}' for name, value in event.values.items()), 200)


def events_within(run: Run) -> list[Event]:
    """Return the events after the first message of a run, in order of time."""
    if not run.events:
        return []
    first, last = run.series.span()
    return sorted((event for event in run.events if first < event.time <= last), key=lambda event: event.time)


def segments(run: Run) -> list[Segment]:
    """Return the parts of a run between changes of its law; none if the law is unknown or never changed."""
    events = events_within(run)
    if run.parameters is None or not events:
        return []
    begin, end = run.series.span()
    laws = [(begin, run.parameters.position_controller.control.controller_type)]
    for event in events:
        law = event.values.get(_LAW)
        if isinstance(law, str) and law != laws[-1][1]:
            laws.append((event.time, law))
    ends = [time for time, _ in laws[1:]] + [end]
    return [_segment(run.series, law, begin, end) for (begin, law), end in zip(laws, ends, strict=True)]


def _segment(series: Series, law: str, begin: float, end: float) -> Segment:
    """Return a part with its numbers, from the position ticks from its begin on and before its end."""
    ahead, aside = series.error('longitudinal'), series.error('lateral')
    squared = (ahead.value**2 + aside.value**2)[(begin <= ahead.time) & (ahead.time < end)]
    torques = [series.torque(wheel) for wheel in ('right', 'left')]
    peaks = np.abs(np.concatenate([line.value[(begin <= line.time) & (line.time < end)] for line in torques]))
    squared, peaks = squared[np.isfinite(squared)], peaks[np.isfinite(peaks)]
    return Segment(shortened(law, 60), begin, end, float(np.sqrt(squared.mean())) if squared.size else None,
                   float(np.sqrt(squared.max())) if squared.size else None,
                   float(peaks.max()) if peaks.size else None)
