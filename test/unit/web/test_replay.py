"""The first screen of a report in a real browser: in view, playing, scrubbed, in step, silent, alone with its data."""

import base64
import io
import json
import re

import moving_picture
import pytest
from helpers.harness import CONFIG
from helpers.measuring import configuration
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from selenium.webdriver import ActionChains, Keys

import mobile_robot_control as mrc
from mobile_robot_control.pages import page
from mobile_robot_control.report import report_writing
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure, rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.runs.words import readable

PHONE, DESKTOP, DURATION = 360, 1280, 2.0
HOSTILE = '</script><img src=x onerror="window.hit=1">\u2028${1}'
PLACES = '''(() => { const box = (name) => document.querySelector(name).getBoundingClientRect();
  return ['.answer', '.replay canvas', '.controls'].map((name) => [box(name).top, box(name).bottom,
    box(name).right, box(name).height]); })()'''
PICTURE = "document.querySelector('canvas').toDataURL()"


@pytest.fixture(scope='module')
def written(tmp_path_factory):
    """Reports of one run and of six, with names that are attacks, by number of runs; and the samples of the first."""
    runs, first = [], None
    for law in ('backstepping', 'fuzzy'):
        parameters = configuration(plant={'duration': DURATION}, position_controller={'controller_type': law})
        samples = list(rollout(parameters, DURATION))
        first = first or samples
        runs.append(Run(f'{law} {HOSTILE}', collect(samples), (), summary(measure(parameters, DURATION, samples)),
                        parameters))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_writing, 'RUN_FIGURES', RUN_FIGURES[:1])
        return {count: report_writing.write_report((runs * 3)[:count], tmp_path_factory.mktemp('report'),
                                                   lambda _: None) for count in (1, 6)}, first


@pytest.fixture
def show(browser, written):
    """Shows a report of some runs; nothing may be logged, and nothing asked for but the page."""
    shown = []

    def open_(count, width=DESKTOP, **options):
        shown.append(written[0][count].as_uri())
        browser.show(written[0][count], width, **options)
        return browser.evaluate

    yield open_
    assert browser.errors() == []
    assert browser.requests() == shown[-1:]


def test_six_runs_are_in_view_and_in_step_and_their_names_run_nothing_on_screen_and_on_paper(show, browser):
    evaluate = show(6, height=800, scheme='dark')
    # answer, numbers and replay without scrolling
    for top, bottom, right, _ in evaluate(PLACES):
        assert 0 <= top < bottom <= 800
        assert right <= DESKTOP
    assert evaluate(PLACES)[1][3] > 300
    assert 'RMS error' in evaluate("document.querySelector('.answer').textContent")
    time, rows, carts = evaluate('''(() => { mrc.clock.set(1.234);
      return [mrc.clock.time, mrc.replay.runs.map((run) => run.columns.time[run.stateAt(1.234).trail.to]),
              mrc.replay.cartsAt(1.234).length]; })()''')
    assert (time, rows, carts) == (1.234, pytest.approx([1.23] * 6), 1)
    assert evaluate("[window.hit ?? 0, mrc.runData.runs[0].name, document.querySelectorAll('img[src=x]').length]") == [
        0, f'backstepping {HOSTILE}', 0]
    # a screen reader finds its way
    assert browser.violations() == []
    browser.media('', 'light')
    assert browser.violations() == []
    # the width of A4
    browser.call('Emulation.setDeviceMetricsOverride', width=718, height=900, deviceScaleFactor=1, mobile=False)
    browser.media('print', 'dark')
    assert evaluate('''[...document.querySelectorAll('body *')].filter((element) => element.getClientRects().length
      && element.getBoundingClientRect().right > 719).map((element) => element.outerHTML.slice(0, 80))''') == []
    assert evaluate("[...document.querySelectorAll('details > *')].every((one) => one.checkVisibility())")
    printed = base64.b64decode(browser.driver.print_page())
    assert printed.startswith(b'%PDF')
    assert len(printed) > 20_000


def test_on_a_phone_nothing_overflows_and_text_has_12_pixels(show):
    evaluate = show(6, PHONE)
    assert evaluate('document.documentElement.scrollWidth') == PHONE
    for *_, right, height in evaluate(PLACES):
        assert right <= PHONE
        assert height > 20
    assert evaluate('''Math.min(...[...document.querySelectorAll('body *')].filter((element) =>
      element.checkVisibility() && [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim()))
      .map((element) => parseFloat(getComputedStyle(element).fontSize)))''') >= 12
    # the figures' own text, which is shown where there are no charts: 9 of the 403 points that a figure is wide
    evaluate('[...document.querySelectorAll(".charted")].forEach((figure) => figure.classList.remove("charted"))')
    assert 9 / 403 * evaluate("document.querySelector('.still img').getBoundingClientRect().width") >= 12


def test_it_plays_to_its_end_and_again_follows_scrubber_and_keys_and_has_the_pixels_of_the_screen(
        show, browser, written):
    evaluate = show(1)
    assert evaluate('mrc.clock.time') == 0
    before, after, x = evaluate(f'''(() => {{ const scrubber = document.querySelector('.controls input');
      const first = {PICTURE};
      scrubber.value = 1; scrubber.dispatchEvent(new Event('input'));
      return [first, {PICTURE}, mrc.replay.runs[0].stateAt(mrc.clock.time).pose[0]]; }})()''')
    assert before != after
    there = next(sample for sample in written[1] if sample.time >= 1.0)
    assert x == pytest.approx(there.tick.pose.x, abs=1e-5)

    def press(key, asked='mrc.clock.time'):
        ActionChains(browser.driver).send_keys(getattr(Keys, key)).perform()
        return evaluate(asked)

    assert [press(key) for key in ('END', 'ARROW_LEFT', 'HOME', 'ARROW_RIGHT', 'ARROW_RIGHT')] == pytest.approx(
        [2.0, 1.98, 0.0, 0.02, 0.04])
    assert evaluate('scrollY') == 0
    # so slow that it does not end meanwhile
    evaluate('(mrc.clock.speed = 0.001)')
    assert [press('SPACE', 'mrc.clock.playing') for _ in range(2)] == [True, False]
    # a focused button has its own space, and a key elsewhere on the page scrolls
    evaluate("document.querySelector('.play').focus()")
    assert press('SPACE', 'mrc.clock.playing')
    evaluate("(mrc.clock.pause(), document.querySelector('summary').focus())")
    assert press('END') < DURATION
    evaluate('mrc.clock.set(0)')
    assert evaluate('''new Promise((done) => { mrc.clock.speed = 16;
      mrc.clock.onChange((clock) => { if (clock.time >= clock.end && !clock.playing) done(clock.time); });
      document.querySelector('.play').click(); })''') == DURATION
    assert evaluate("document.querySelector('.time').textContent") == '2.00 s of 2.00 s'
    # so slow that it has not ended by the next frame
    evaluate('(mrc.clock.speed = 0.01)')
    again = evaluate('''new Promise((done) => { document.querySelector('.play').click(); mrc.clock.onChange((clock) => {
      if (clock.playing && clock.time > 0) { clock.pause(); done(clock.time); } }); })''')
    assert 0 < again < DURATION
    assert evaluate("document.querySelector('.play').textContent").endswith('Play')
    browser.call('Emulation.setDeviceMetricsOverride', width=PHONE, height=800, deviceScaleFactor=2, mobile=True)
    drawn, shown = evaluate('''new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => {
      mrc.clock.set(1); const canvas = document.querySelector('canvas');
      done([canvas.width, canvas.clientWidth]); })))''')
    assert drawn == 2 * shown
    picture = base64.b64decode(evaluate(PICTURE).partition(',')[2])
    assert len(Image.open(io.BytesIO(picture)).convert('RGBA').getcolors(1 << 20)) > 20
    # units are the same in the sentence and in the replay
    values = [0.009667, 0.0, -1.2345, 0.00001234, 0.123456, 1234.5, 9.996e-5, 5e-4, 0.0999, 2e9]
    assert evaluate(f'{values}.map(value => mrc.withUnit(value, "N m"))') == [
        readable(value, 'N m').replace('\xa0', ' ') for value in values]


def test_the_page_may_run_no_other_script_and_fetch_nothing(browser, tmp_path):
    file = tmp_path / 'page.html'
    injected = '''<script>window.hit = 1</script><img src="x" onerror="window.hit = 2">
<script>document.title = 'allowed?'</script><img src="https://example.org/a.png">'''
    file.write_text(page.page('title', [injected], scripts=['window.allowed = 1;']), encoding='utf-8')
    browser.show(file, DESKTOP)
    assert browser.evaluate('[window.hit ?? 0, window.allowed, document.title]') == [0, 1, 'title']
    assert browser.evaluate("fetch('https://example.org').then(() => 'fetched', () => 'refused')") == 'refused'
    assert all('Content Security Policy' in message for message in browser.errors())
    assert browser.requests() == [file.as_uri()]


@settings(max_examples=30)
@given(st.text() | st.sampled_from(['</script>', '<!--', '\u2028\u2029', '\udcff', '"\\']))
def test_a_text_in_a_block_of_numbers_cannot_end_it_and_is_read_as_it_was(text):
    block = page.json_block('run-data', {'name': text})
    inner = re.fullmatch(r'<script type="application/json" id="run-data">(.*)</script>', block).group(1)
    assert '<' not in inner
    assert inner.isascii()
    assert json.loads(inner) == {'name': text}
    with pytest.raises(ValueError, match='not JSON compliant'):
        page.json_block('run-data', {'value': float('nan')})


def test_the_same_runs_give_the_same_page_which_loads_nothing_from_elsewhere(quick, tmp_path):
    parameters = configuration(plant={'duration': 0.1})
    first, second = (report_writing.write_report([
        Run('run', collect(rollout(parameters, 0.1)), (), {}, parameters)], tmp_path / name, lambda _: None)
        for name in ('first', 'second'))
    assert first.read_bytes() == second.read_bytes()
    text, figure = first.read_text(encoding='utf-8'), first.parent / 'figures' / RUN_FIGURES[0].name
    assert text.count('src="data:image/svg+xml,') == 1
    assert not re.search(r'(src|href)="(?!data:|#)', text)
    assert '@import' not in text
    assert figure.with_suffix('.png').read_bytes().startswith(b'\x89PNG')
    assert '<svg' in figure.with_suffix('.svg').read_text(encoding='utf-8')


def test_the_moving_picture_is_played_from_the_replay_and_left_as_it_is_without_a_browser(
        browser, tmp_path, monkeypatch):
    monkeypatch.setattr(moving_picture, 'FRAMES', 3)
    monkeypatch.setattr(moving_picture, 'LAP', 4.0)
    moving_picture.write_moving_picture(CONFIG, tmp_path / 'moving.gif')
    with Image.open(tmp_path / 'moving.gif') as picture:
        assert picture.n_frames == 3
        assert picture.width > 600
        first = picture.convert('RGB').tobytes()
        picture.seek(2)
        assert picture.convert('RGB').tobytes() != first
    monkeypatch.setenv('PATH', str(tmp_path))
    with pytest.raises(SystemExit, match='install chromium and chromium-driver'):
        moving_picture.write_moving_picture(CONFIG, tmp_path / 'none.gif')
    assert not (tmp_path / 'none.gif').exists()


def test_a_notebook_shows_replay_and_report_of_runs(browser, quick, tmp_path):
    formatters = pytest.importorskip('IPython.core.formatters')
    run = mrc.simulate(duration=0.4)
    for n, shown in enumerate((run.replay(run, run), run.report(tmp_path / 'report', run))):
        found, _ = formatters.DisplayFormatter().format(shown)
        file = tmp_path / f'{n}.html'
        file.write_text(f'<!DOCTYPE html><title>notebook</title>{found["text/html"]}', encoding='utf-8')
        browser.show(file, DESKTOP)
        browser.driver.switch_to.frame(0)
        assert browser.evaluate('mrc.replay.runs.length') == 3 - n
        browser.evaluate('mrc.clock.set(0.2)')
        browser.driver.switch_to.default_content()
        assert browser.errors() == []
    assert shown.file.read_text(encoding='utf-8') == shown.html
    assert str(shown.file) in repr(shown)
    with pytest.raises(mrc.ParameterError, match='7 runs: a page tells 6 apart'):
        run.replay(*[run] * 6)
