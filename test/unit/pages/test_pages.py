"""The pages in a real browser: every picture loads, nothing overflows, pages turn dark, nothing is fetched."""

import re

import pytest
from measuring import configuration

from mobile_robot_control.pages import page, report_writing
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.simulation.rollout import rollout

PHONE, DESKTOP = 360, 1280
_BROKEN = '[...document.images].filter(image => !image.complete || image.naturalWidth < 1).length'
_OVERFLOW = 'document.documentElement.scrollWidth - document.documentElement.clientWidth'
# elements beyond the right edge of the window, except in boxes that scroll by themselves
_WIDE = '''[...document.querySelectorAll('body *')].filter(element => !element.closest('.scroll, pre') &&
  element.getBoundingClientRect().right > innerWidth + 1).map(element => element.tagName)'''

_CORNER = '''(async () => { const canvas = document.createElement('canvas'); canvas.width = canvas.height = 4;
  const pen = canvas.getContext('2d'); pen.drawImage(document.images[0], 0, 0, 400, 300);
  return [...pen.getImageData(1, 1, 1, 1).data]; })()'''


@pytest.fixture(scope='module')
def written(tmp_path_factory):
    """A report of two runs with a problem each, one of them with a long name."""
    folder = tmp_path_factory.mktemp('report')
    runs = []
    for law, name in (('backstepping', 'a'), ('fuzzy', 'a_name_as_long_as_people_give_their_folders_of_runs')):
        parameters = configuration(position_controller={'controller_type': law})
        series = collect(rollout(parameters, 0.5))
        runs.append(Run(name, series, ('3 of 51 messages missing on odom',), {'duration': 0.5}, parameters))
    return report_writing.write_report(runs, folder, lambda _: None)


def test_the_page_loads_nothing_from_elsewhere(written):
    text = written.read_text(encoding='utf-8')
    assert text.count('src="data:image/svg+xml,') == len(report_writing.RUN_FIGURES)
    assert not re.search(r'(src|href)="(?!data:|#)', text)
    assert '@import' not in text
    for figure in report_writing.RUN_FIGURES:
        stem = written.parent / 'figures' / figure.name
        assert stem.with_suffix('.png').read_bytes().startswith(b'\x89PNG')
        assert '<svg' in stem.with_suffix('.svg').read_text(encoding='utf-8')


@pytest.mark.parametrize('width', [PHONE, DESKTOP])
def test_pictures_load_and_nothing_overflows(browser, written, width):
    browser.show(written, width)
    assert browser.evaluate('innerWidth') == width
    assert browser.evaluate('document.images.length') == len(report_writing.RUN_FIGURES)
    assert browser.evaluate(_BROKEN) == 0
    assert browser.evaluate(_OVERFLOW) == 0
    assert browser.evaluate(_WIDE) == []
    # side by side on a desktop, one below the other on a phone
    columns = browser.evaluate("getComputedStyle(document.querySelector('.grid')).gridTemplateColumns")
    assert len(columns.split()) == (1 if width == PHONE else 2)


def test_the_page_turns_dark(browser, written):
    ground = 'getComputedStyle(document.body).backgroundColor'
    browser.show(written, DESKTOP)
    assert browser.evaluate(ground) == 'rgb(255, 255, 255)'
    browser.show(written, DESKTOP, 'dark')
    assert browser.evaluate(ground) == 'rgb(21, 24, 28)'
    # the pictures turn dark too, by style sheets of their own
    assert browser.evaluate(_CORNER)[:3] == [21, 24, 28]


def test_the_page_prints_on_light_ground(browser, written):
    browser.show(written, DESKTOP, 'dark')
    browser.media('print', 'dark')
    assert browser.evaluate('getComputedStyle(document.body).backgroundColor') == 'rgb(255, 255, 255)'
    assert browser.evaluate(_CORNER)[:3] == [255, 255, 255]


@pytest.mark.parametrize(('body', 'count'), [
    ('<img src="data:image/png;base64,AAAA">', _BROKEN), ('<p style="width:500px">wide</p>', _OVERFLOW),
])
def test_broken_pictures_and_overflow_are_detected(browser, tmp_path, body, count):
    file = tmp_path / 'broken.html'
    file.write_text(page.page('broken', [body]), encoding='utf-8')
    browser.show(file, PHONE)
    assert browser.evaluate(count) > 0
