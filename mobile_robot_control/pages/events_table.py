"""The changes of runs: a table of their parts, one for each law, and a list of their events."""

from collections.abc import Iterator, Sequence
from html import escape

from mobile_robot_control.pages.page import html_table
from mobile_robot_control.pages.readable import quantities
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.segments import event_text, events_within, segments


def event_parts(runs: Sequence[Run]) -> Iterator[str]:
    """Yield the parts and the events of runs that have any, as HTML."""
    for run in runs:
        events = events_within(run)
        if not events:
            continue
        if len(runs) > 1:
            yield f'<h3>{escape(run.name)}</h3>'
        parts = segments(run)
        if len(parts) > 1:
            columns = (quantities([getattr(part, name) for part in parts], unit)
                       for name, unit in (('rms_error', 'm'), ('max_error', 'm'), ('peak_torque', 'N m')))
            spans = (f'{part.begin:.2f} to {part.end:.2f} s' for part in parts)
            yield html_table(('law', 'time', 'RMS error', 'largest error', 'peak torque'),
                             zip((escape(part.law.replace('_', ' ')) for part in parts), spans, *columns, strict=True))
        rows = ([f'{event.time:.3f} s', *(f'<code>{escape(text)}</code>' for text in (event.node, event_text(event)))]
                for event in events)
        yield html_table(('time', 'node', 'event'), rows, numbers=False)
