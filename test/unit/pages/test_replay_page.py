"""The first screen of a report in a real browser: in view, playing, scrubbed, in step, silent, alone with its data."""

import base64
import io
import json
import re

import moving_picture
import pytest
from harness import CONFIG
from hypothesis import given, settings
from hypothesis import strategies as st
from measuring import configuration
from PIL import Image

import mobile_robot_control as mrc
from mobile_robot_control.pages import page, report_writing
from mobile_robot_control.pages.readable import readable
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.simulation.metrics import summary
from mobile_robot_control.simulation.rollout import measure, rollout

PHONE, DESKTOP, DURATION = 360, 1280, 2.0
HOSTILE = '</script><img src=x onerror="window.hit=1">\u2028${1}'
PLACES = '''(() => { const box = (name) => document.querySelector(name).getBoundingClientRect();
  return ['.answer', '.replay canvas', '.controls'].map((name) => [box(name).top, box(name).bottom,
    box(name).right, box(name).height]); })()'''


@pytest.fixture(scope='module')
def written(tmp_path_factory):
    """Reports of one run and of six, with names that are attacks, by number of runs."""
    runs = []
    for law in ('backstepping', 'fuzzy'):
        parameters = configuration(plant={'duration': DURATION}, position_controller={'controller_type': law})
        samples = list(rollout(parameters, DURATION))
        metrics = summary(measure(parameters, DURATION, samples))
        runs.append(Run(f'{law} {HOSTILE}', collect(samples), (), metrics, parameters))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_writing, 'RUN_FIGURES', RUN_FIGURES[:1])
        return {count: report_writing.write_report((runs * 3)[:count], tmp_path_factory.mktemp('report'),
                                                   lambda _: None) for count in (1, 2, 6)}


@pytest.fixture
def show(browser, written):
    """Shows a report of some runs; nothing may be logged, and nothing asked for but the page."""
    shown = []

    def open_(count, width=DESKTOP, **options):
        shown.append(written[count].as_uri())
        browser.show(written[count], width, **options)
        return browser.evaluate

    yield open_
    assert browser.errors() == []
    assert browser.requests() == shown[-1:]
    browser.call('Emulation.setScriptExecutionDisabled', value=False)


def press(browser, *keys):
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys

    chain = ActionChains(browser.driver)
    for key in keys:
        chain.send_keys(getattr(Keys, key))
    chain.perform()


def test_the_first_screen_of_a_desktop_has_answer_numbers_and_replay_without_scrolling(show):
    evaluate = show(6, height=800)
    for top, bottom, right, _ in evaluate(PLACES):
        assert 0 <= top < bottom <= 800
        assert right <= DESKTOP
    assert evaluate(PLACES)[1][3] > 300
    assert 'RMS error' in evaluate("document.querySelector('.answer').textContent")


def test_it_plays_to_its_end_and_begins_again(show, browser):
    evaluate = show(1)
    assert evaluate('mrc.clock.time') == 0
    end = evaluate('''new Promise((done) => { mrc.clock.speed = 16;
      mrc.clock.onChange((clock) => { if (clock.time >= clock.end && !clock.playing) done(clock.time); });
      document.querySelector('.play').click(); })''')
    assert end == DURATION
    assert evaluate("document.querySelector('.time').textContent") == '2.00 s of 2.00 s'
    # so slow that it has not ended by the next frame
    evaluate('(mrc.clock.speed = 0.01)')
    again = evaluate('''new Promise((done) => { document.querySelector('.play').click(); mrc.clock.onChange((clock) => {
      if (clock.playing && clock.time > 0) { clock.pause(); done(clock.time); } }); })''')
    assert 0 < again < DURATION
    assert evaluate("document.querySelector('.play').textContent").endswith('Play')


def test_the_scrubber_moves_the_robot_and_the_drawing(show):
    evaluate = show(1)
    before, after, x = evaluate('''(() => { const canvas = document.querySelector('canvas');
      const scrubber = document.querySelector('.controls input'), first = canvas.toDataURL();
      scrubber.value = 1; scrubber.dispatchEvent(new Event('input'));
      return [first, canvas.toDataURL(), mrc.replay.runs[0].stateAt(mrc.clock.time).pose[0]]; })()''')
    assert before != after
    parameters = configuration(plant={'duration': DURATION}, position_controller={'controller_type': 'backstepping'})
    there = next(sample for sample in rollout(parameters, DURATION) if sample.time >= 1.0)
    assert x == pytest.approx(there.tick.pose.x, abs=1e-5)


def test_keys_move_time_and_space_plays(show, browser):
    evaluate = show(1)
    times = []
    for key in ('END', 'ARROW_LEFT', 'HOME', 'ARROW_RIGHT', 'ARROW_RIGHT'):
        press(browser, key)
        times.append(evaluate('mrc.clock.time'))
    assert times == pytest.approx([2.0, 1.98, 0.0, 0.02, 0.04])
    assert evaluate('scrollY') == 0
    # so slow that it does not end meanwhile
    evaluate('(mrc.clock.speed = 0.001)')
    playing = []
    for _ in range(2):
        press(browser, 'SPACE')
        playing.append(evaluate('mrc.clock.playing'))
    assert playing == [True, False]
    # a focused button has its own space, and a key elsewhere on the page scrolls
    evaluate("document.querySelector('.play').focus()")
    press(browser, 'SPACE')
    assert evaluate('mrc.clock.playing')
    evaluate('mrc.clock.pause()')
    evaluate("document.querySelector('summary').focus()")
    press(browser, 'END')
    assert evaluate('mrc.clock.time') < DURATION


def test_several_runs_move_in_step_and_their_names_run_nothing(show):
    evaluate = show(2)
    time, rows = evaluate('''(() => { mrc.clock.set(1.234);
      return [mrc.clock.time, mrc.replay.runs.map((run) => run.columns.time[run.stateAt(1.234).trail.to])]; })()''')
    assert time == 1.234
    assert rows == pytest.approx([1.23, 1.23])
    assert evaluate('mrc.replay.cartsAt(1.234).length') == 1
    # their names are texts, and run nothing
    assert evaluate('window.hit') is None
    assert evaluate('mrc.runData.runs[0].name') == f'backstepping {HOSTILE}'
    assert evaluate("document.querySelectorAll('img[src=x]').length") == 0


@pytest.mark.parametrize('count', [1, 6])
def test_on_a_phone_nothing_overflows_and_text_has_12_pixels(show, count):
    evaluate = show(count, PHONE)
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


def test_a_screen_reader_finds_its_way(show, browser):
    show(6, scheme='dark')
    assert browser.violations() == []
    browser.media('', 'light')
    assert browser.violations() == []


def test_paper_with_six_runs_loses_nothing(show, browser):
    evaluate = show(6, 718, scheme='dark')  # A4
    browser.media('print', 'dark')
    assert evaluate('''[...document.querySelectorAll('body *')].filter((element) => element.getClientRects().length
      && element.getBoundingClientRect().right > 719).map((element) => element.outerHTML.slice(0, 80))''') == []
    assert evaluate("[...document.querySelectorAll('details > *')].every((one) => one.checkVisibility())")
    assert evaluate("document.querySelector('#replay').checkVisibility()") is False
    assert evaluate("document.querySelector('.answer').checkVisibility()")
    printed = base64.b64decode(browser.driver.print_page())
    assert printed.startswith(b'%PDF')
    assert len(printed) > 20_000


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


def test_a_number_that_json_lacks_is_refused():
    with pytest.raises(ValueError, match='not JSON compliant'):
        page.json_block('run-data', {'value': float('nan')})


def test_without_scripts_the_answer_and_the_pictures_are_there(show):
    evaluate = show(1, scripts=False)
    assert evaluate("document.querySelector('#replay').checkVisibility()") is False
    assert evaluate("document.querySelector('.answer').checkVisibility()")
    assert evaluate('document.images.length') == 1
    assert evaluate('document.images[0].naturalWidth') > 0


def test_the_canvas_has_as_many_pixels_as_the_screen(show, browser):
    evaluate = show(1)
    browser.call('Emulation.setDeviceMetricsOverride', width=PHONE, height=800, deviceScaleFactor=2, mobile=True)
    drawn, shown = evaluate('''new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => {
      mrc.clock.set(1); const canvas = document.querySelector('canvas');
      done([canvas.width, canvas.clientWidth]); })))''')
    assert drawn == 2 * shown
    picture = evaluate("document.querySelector('canvas').toDataURL()").partition(',')[2]
    assert len(Image.open(io.BytesIO(base64.b64decode(picture))).convert('RGBA').getcolors(1 << 20)) > 20


def test_the_same_runs_give_the_same_page(quick, tmp_path):
    parameters = configuration(plant={'duration': 0.1})
    first, second = (report_writing.write_report([
        Run('run', collect(rollout(parameters, 0.1)), (), {}, parameters)], tmp_path / name, lambda _: None)
        for name in ('first', 'second'))
    assert first.read_bytes() == second.read_bytes()


def test_units_are_the_same_in_the_sentence_and_in_the_replay(show):
    values = [0.009667, 0.0, -1.2345, 0.00001234, 0.123456, 1234.5, 9.996e-5, 5e-4, 0.0999, 2e9]
    assert show(1)(f'{values}.map(value => mrc.withUnit(value, "N m"))') == [
        readable(value, 'N m').replace('\xa0', ' ') for value in values]


def test_the_moving_picture_is_played_from_the_replay(browser, tmp_path, monkeypatch):
    monkeypatch.setattr(moving_picture, 'FRAMES', 3)
    monkeypatch.setattr(moving_picture, 'HYBRID_LEMNISCATE', moving_picture.HYBRID_LEMNISCATE._replace(duration=1.0))
    moving_picture.write_moving_picture(CONFIG, tmp_path / 'moving.gif')
    with Image.open(tmp_path / 'moving.gif') as picture:
        assert picture.n_frames == 3
        assert picture.width > 600
        first = picture.convert('RGB').tobytes()
        picture.seek(2)
        assert picture.convert('RGB').tobytes() != first


def test_without_a_browser_the_moving_picture_is_left_as_it_is_with_the_remedy(tmp_path, monkeypatch):
    monkeypatch.setattr(moving_picture, 'HYBRID_LEMNISCATE', moving_picture.HYBRID_LEMNISCATE._replace(duration=0.1))
    monkeypatch.setenv('PATH', str(tmp_path))
    with pytest.raises(SystemExit, match='install chromium and chromium-driver'):
        moving_picture.write_moving_picture(CONFIG, tmp_path / 'moving.gif')
    assert not (tmp_path / 'moving.gif').exists()


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
