"""What holds of the numbers of a search or study, as part of a page: warnings, margins, what was modelled."""

from collections.abc import Iterator
from html import escape

from mobile_robot_control.analysis.promises import Promise, promise_values, spread_text, warnings_of
from mobile_robot_control.pages import page
from mobile_robot_control.pages.readable import quantity

_HEAD = ('loop', 'gain margin', 'lower gain margin', 'delay margin', 'least gain margin at', 'least delay margin at')


def promise_parts(found: Promise) -> Iterator[str]:
    """Yield what holds of numbers, as HTML."""
    warnings = warnings_of(found)
    if warnings:
        yield page.warning('Not to be expected of a robot', warnings)
    values = promise_values(found)
    rows = [[escape(name.replace('_', ' ')), quantity(loop['gain'], ''), quantity(loop['lowest_gain'], ''),
             quantity(loop['delay'], 's'), quantity(loop['gain'] and loop['gain_time'], 's'),
             quantity(loop['delay'] and loop['delay_time'], 's')]
            for name, loop in values['margins'].items() if isinstance(loop, dict)]
    yield page.html_table(_HEAD, rows)
    yield ('<p class="soft">A gain margin is the factor on the output of a controller from which on its loop is not '
           'stable, a delay margin the further delay; a dash where none is known or none was found. Times are those '
           'on the lap where the margins are smallest.</p>')
    modelled = [f'{effect}: {value}' for effect, value in values['modelled'].items()]
    left_out = values['margins']['not_in_margins']
    for title, texts in (('Modelled', modelled), ('Not modelled: the error of a robot that has any of it is unknown',
                                                  values['not_modelled']), ('Not in the margins', left_out),
                          ('Ruled out', values['ruled_out']),
                          ('Spread', [spread_text(found.spread)] if found.spread else [])):
        if texts:
            yield f'<h3>{escape(title)}</h3><p>{escape("; ".join(texts))}.</p>'
