"""The first screen of a report: the answer in a sentence, five numbers of each run, and the replay."""

from collections.abc import Sequence
from html import escape

from mobile_robot_control.pages import page
from mobile_robot_control.pages.answer import key_numbers, sentence
from mobile_robot_control.pages.replay_data import replay_data
from mobile_robot_control.runs.run import Run
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.web.assets import asset

_SCRIPTS = ('basics.js', 'clock.js', 'scene.js', 'replay.js', 'report.js')


def first_screen(title: str, runs: Sequence[Run]) -> str:
    """Return title, answer, numbers and, where a run has moved, the replay with its data, as HTML."""
    inner = [f'<h1>{escape(title)}</h1>', f'<p class="answer">{escape(sentence(runs))}</p>', _numbers(runs)]
    try:
        data = replay_data(runs)
        block = '' if data is None else page.json_block('run-data', data)
    except Exception as error:  # whatever a run contains: the rest of the page is made
        reason = f'cannot be shown: {type(error).__name__}: {shortened(str(error))}'
        return f'<section class="first">{"".join(inner)}</section>\n{page.warning("Replay", [reason])}'
    # shown by its script; without scripts the pictures below tell the same
    inner += ['<div class="replay" id="replay" hidden></div>'] if block else []
    return f'<section class="first">{"".join(inner)}</section>\n{block}'


def _numbers(runs: Sequence[Run]) -> str:
    """Return the numbers of a run as a list, or of several as a table, as HTML."""
    found = key_numbers(runs)
    if len(runs) == 1:
        items = ''.join(f'<div><dt>{escape(number.label)}</dt><dd>{escape(number.text)}</dd></div>'
                        for number in found[0])
        return f'<dl class="numbers">{items}</dl>'
    rows = ([page.breakable(run.name), *(escape(number.text) for number in row)]
            for run, row in zip(runs, found, strict=True))
    return page.html_table(['', *(number.label for number in found[0])], rows)


def replay_scripts() -> list[str]:
    """Return the scripts of the replay, in their order; the last one starts it."""
    return list(map(asset, _SCRIPTS))


def replay_styles() -> list[str]:
    """Return the style sheets of the first screen."""
    return [asset('replay.css')]
