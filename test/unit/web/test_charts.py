"""The charts of a report in a real browser: values under the pointer, one range, one cursor, switches, the slider."""

import csv
from xml.etree import ElementTree

import pytest
from helpers.measuring import configuration
from helpers.processes import wait_until
from selenium.webdriver import ActionChains, Keys

from mobile_robot_control.report import report_writing
from mobile_robot_control.runs.record import Event
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES
from mobile_robot_control.runs.samples import collect

PHONE, DESKTOP, DURATION = 360, 1280, 4.0
SECOND = 'a_second_run_with_a_name_of_some_length'
# at a time on the charts, values as the legend of a chart has them
LEGEND = '[...document.querySelectorAll("#distance .legend .value")].map(value => value.textContent)'
NEAREST = '''mrc.charts.data.charts.find(chart => chart.figure === "distance").lines.filter(
  line => line.kind === "value").map(line => { const [times, values] = [line.time, line.value].map(
  place => mrc.charts.data.columns[place]); return values[mrc.nearest(times, TIME)]; })'''
SMALL = '''[...document.querySelectorAll(".charts *, .chart-bar *, .contents *")].filter(
  element => element.textContent.trim() && parseFloat(getComputedStyle(element).fontSize) < 12).length'''
WIDE = '''[...document.querySelectorAll("body *")].filter(element => !element.closest(".scroll, pre") &&
  element.getClientRects().length && element.getBoundingClientRect().right > innerWidth + 1).map(one => one.tagName)'''
OVERFLOW = 'document.documentElement.scrollWidth - document.documentElement.clientWidth'
COLUMNS = '[...document.querySelectorAll("#metrics tr")].map(one => one.getBoundingClientRect().left)'
SHOWN = '''[[...document.querySelectorAll("figure img")].filter(one => one.getClientRects().length).length,
  [...document.querySelectorAll(".chart")].filter(one => one.getClientRects().length).length > 0,
  document.querySelector("#replay").checkVisibility(), document.querySelector(".answer").checkVisibility()]'''
PLANE = 'document.querySelector("#replay canvas").toDataURL()'
EVENTS = (Event(1.0, 'position_controller', {'backstepping.p': 2.5}),
          Event(2.5, 'position_controller', {'controller_type': 'fuzzy'}))
BLUE, ORANGE, LIMIT = '0,114,178', '213,94,0', '138,75,0'
BLUE_ON_DARK = '86,180,233'
WHOLE, PLUS = (f'[...document.querySelectorAll(".chart-bar button")].find(one => one.textContent === "{name}")'
               for name in ('whole run', '+'))


@pytest.fixture(scope='module', autouse=True)
def still():
    """Write no pictures: these tests look at charts."""
    with pytest.MonkeyPatch.context() as patch:
        picture = '<svg xmlns="http://www.w3.org/2000/svg" width="4" height="3"/>'
        patch.setattr(report_writing, 'draw_and_save', lambda *_: picture)
        yield


def write(folder, *names, start=(1.1, 0.0, 1.2), limit=0.5):
    runs = []
    for name, law in zip(names, ('backstepping', 'fuzzy'), strict=False):
        parameters = configuration(position_controller={'controller_type': law},
                                   plant={'initial_pose': list(start), 'max_wheel_torque': limit})
        runs.append(Run(name, collect(rollout(parameters, DURATION)), (), {'duration': DURATION}, parameters, {},
                        EVENTS))
    return report_writing.write_report(runs, folder, lambda _: None)


@pytest.fixture(scope='module')
def pair(tmp_path_factory):
    return write(tmp_path_factory.mktemp('pair'), '<b>first</b>', SECOND)


@pytest.fixture
def charts(browser, pair):
    """The charts of two runs: loaded once for tests that leave them as they were, but for time and range."""
    if browser.evaluate('[location.href, innerWidth]') != [pair.as_uri(), DESKTOP]:
        browser.show(pair, DESKTOP)
    browser.evaluate(f'(mrc.clock.set(0), mrc.charts.setRange(0, {DURATION}))')
    return browser


def inked(browser, figure):
    """Return the colours on a chart's canvas."""
    return set(browser.evaluate(f'''(() => {{ const canvas = document.querySelector("#{figure} canvas");
      const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data, found = new Set();
      for (let n = 0; n < data.length; n += 4) if (data[n + 3] === 255) found.add([...data.slice(n, n + 3)].join());
      return [...found]; }})()'''))


def drag(browser, figure, *fractions):
    """Move the pointer over the first chart of a figure, to fractions of its width; pressed between the first two."""
    over = browser.driver.find_element('css selector', f'#{figure} .u-over')
    browser.driver.execute_script('arguments[0].scrollIntoView({block: "center"})', over)
    chain = ActionChains(browser.driver, duration=0)
    for n, fraction in enumerate(fractions):
        chain.move_to_element_with_offset(over, round((fraction - 0.5) * over.size['width']), 0)
        if n == 0 and len(fractions) > 1:
            chain.click_and_hold()
    (chain.release() if len(fractions) > 1 else chain).perform()


def test_every_panel_is_a_chart_that_fits_light_and_dark_and_a_picture_on_paper(browser, pair):
    evaluate, on_paper = browser.evaluate, [len(RUN_FIGURES), False, False, True]
    browser.show(pair, DESKTOP, scripts=False)
    assert evaluate(SHOWN) == on_paper
    for width in (PHONE, DESKTOP):
        browser.show(pair, width)
        assert (browser.requests(), browser.errors()) == ([pair.as_uri()], [])
        assert [evaluate(one) for one in (OVERFLOW, WIDE, SMALL, SHOWN)] == [0, [], 0, [0, True, True, True]]
        # metrics stand in two columns where there is room, and all of the bar is in sight
        assert len({*evaluate(COLUMNS)}) == (1 if width == PHONE else 2)
        assert evaluate('document.querySelector(".chart-bar").scrollWidth') <= width
    assert evaluate('document.querySelectorAll(".chart .uplot").length') == sum(
        len(figure.panels) for figure in RUN_FIGURES)
    # the name of a run is a text
    assert '<b>first</b>' in evaluate('document.querySelector(".chart-bar .switch .name").textContent')
    assert evaluate('document.querySelectorAll(".charts b, .chart-bar b").length') == 0
    # limits are drawn and named where there are torques
    assert 'limit ±0.5 N m' in evaluate('document.querySelector("#torque .head").textContent')
    assert [LIMIT in inked(browser, figure) for figure in ('torque', 'power')] == [True, False]
    assert evaluate('[...document.querySelectorAll(".contents a")].map(one => one.hash.slice(1))') == [
        'metrics', 'events', 'figures', *(figure.name for figure in RUN_FIGURES), 'configuration']
    assert evaluate('[...document.querySelectorAll(".contents a")].every(one => document.querySelector(one.hash))')
    assert BLUE in inked(browser, 'distance')
    browser.media('', 'dark')
    wait_until(lambda: BLUE_ON_DARK in inked(browser, 'distance'), 30.0, 0.05)
    browser.media('print', 'dark')
    assert evaluate(SHOWN) == on_paper
    # paper is light
    assert evaluate('getComputedStyle(document.body).backgroundColor') == 'rgb(255, 255, 255)'
    browser.media('', 'light')


def test_the_pointer_shows_values_with_units_at_its_time_in_all_charts(charts):
    drag(charts, 'distance', 0.5)
    wait_until(lambda: charts.evaluate('mrc.charts.hover') is not None, 30.0, 0.02)
    assert charts.evaluate('mrc.charts.hover') == pytest.approx(0.5 * DURATION, abs=0.05)
    expected = charts.evaluate(NEAREST.replace('TIME', 'mrc.charts.hover'))

    def shown():
        return [(text.split() + ['', ''])[:2] for text in charts.evaluate(LEGEND)]

    # a chart that has just come in sight follows a moment later
    wait_until(lambda: [unit for _, unit in shown()] == ['cm', 'cm'], step=0.02)
    wait_until(lambda: [float(number) for number, _ in shown()] == pytest.approx(expected, rel=1e-3), step=0.02)
    assert charts.evaluate('document.querySelector(".chart-bar .time").textContent').startswith('t = 2.0')
    # the crosshair of a neighbour is at the same time; away from the charts they show the time of the page
    wait_until(lambda: charts.evaluate(
        'parseFloat(document.querySelector("#heading .u-cursor-x").style.transform.slice(10))') > 100, step=0.02)
    charts.call('Input.dispatchMouseEvent', type='mouseMoved', x=2, y=2)
    wait_until(lambda: charts.evaluate('mrc.charts.hover') is None, 30.0, 0.02)
    assert charts.evaluate('document.querySelector(".chart-bar .time").textContent') == 't = 0.00 s'


def test_a_click_sets_the_clock_which_moves_every_cursor_and_dragging_zooms_every_chart(charts):
    drag(charts, 'errors', 0.25, 0.25)
    assert charts.evaluate('mrc.clock.time') == pytest.approx(0.25 * DURATION, abs=0.05)
    places = '''[...document.querySelectorAll(".now")].map(mark => parseFloat(mark.style.transform.slice(11))
      / mark.parentElement.clientWidth)'''
    charts.evaluate('(mrc.clock.set(3), document.querySelector("#errors").scrollIntoView())')
    wait_until(lambda: charts.evaluate(f'{places}.filter(place => Math.abs(place - 0.75) < 0.01).length') > 3, 30.0,
               0.02)
    charts.evaluate('(mrc.charts.hover = null, mrc.clock.play())')
    wait_until(lambda: charts.evaluate('mrc.clock.time') > 3.1, 20.0, 0.02)
    charts.evaluate('mrc.clock.pause()')
    assert charts.evaluate(f'Math.max(...{places})') > 0.76
    charts.evaluate('mrc.clock.set(0)')
    drag(charts, 'errors', 0.25, 0.4, 0.5)
    wait_until(lambda: charts.evaluate('mrc.charts.zoomed'), 30.0, 0.02)
    assert charts.evaluate('mrc.charts.range') == pytest.approx([0.25 * DURATION, 0.5 * DURATION], abs=0.05)
    # a drag is no click
    assert charts.evaluate('mrc.clock.time') == 0.0
    charts.evaluate('''document.querySelector("#velocity .u-over").dispatchEvent(
      new MouseEvent("dblclick", {bubbles: true}))''')
    assert charts.evaluate('mrc.charts.range') == [0.0, DURATION]
    # and by keyboard
    charts.evaluate(f'{PLUS}.focus()')
    ActionChains(charts.driver).send_keys(Keys.ENTER).perform()
    wait_until(lambda: charts.evaluate('mrc.charts.zoomed'), 30.0, 0.02)
    assert not charts.evaluate(f'{WHOLE}.disabled')
    charts.evaluate(f'{WHOLE}.click()')
    assert charts.evaluate('mrc.charts.range') == [0.0, DURATION]


def test_a_run_is_switched_off_in_every_chart_by_its_name_and_others_are_shown_against_the_first(charts):
    assert {BLUE, ORANGE} <= inked(charts, 'distance')
    charts.evaluate('document.querySelector("#errors .legend .switch").focus()')
    ActionChains(charts.driver).send_keys(Keys.SPACE).perform()
    for figure in ('distance', 'path', 'energy'):
        wait_until(lambda figure=figure: BLUE not in inked(charts, figure), 30.0, 0.05)
        assert ORANGE in inked(charts, figure)
    assert charts.evaluate('document.querySelector(".chart-bar .switch").getAttribute("aria-pressed")') == 'false'
    charts.evaluate('document.querySelector(".chart-bar .switch").click()')
    wait_until(lambda: BLUE in inked(charts, 'distance'), 30.0, 0.05)
    # differences of the other runs to the first are in place of their values
    charts.evaluate('document.querySelector("#distance").scrollIntoView()')
    differences = '[...document.querySelectorAll(".chart-bar button")].pop().click()'
    charts.evaluate(differences)
    wait_until(lambda: BLUE not in inked(charts, 'distance'), 30.0, 0.05)
    assert ORANGE in inked(charts, 'distance')
    wait_until(lambda: charts.evaluate(LEGEND)[0] == 'first', 30.0, 0.05)
    charts.evaluate(differences)


def test_a_run_is_hidden_in_the_plane_and_the_plane_is_zoomed_and_dragged(charts):
    charts.evaluate('mrc.clock.set(2)')
    plane = [charts.evaluate(PLANE)]
    for act in ('document.querySelector("#replay .switch").click()', ) * 2 + (
            'document.querySelector("#replay button[title^=\'Zoom into\']").click()',
            'mrc.replay.scene.pan(40, 10)',
            'document.querySelector("#replay button[title^=\'Zoom out\']").click()'):
        charts.evaluate(act)
        plane.append(charts.evaluate(PLANE))
    before, hidden, shown, zoomed, moved, out = plane
    assert before == shown == out
    assert len({before, hidden, zoomed, moved}) == 4


def test_what_a_chart_shows_is_saved_as_numbers_and_as_a_drawing(charts):
    charts.evaluate('mrc.charts.setRange(1, 2)')
    saved = [charts.evaluate(f'''new Promise((done) => {{
      const make = URL.createObjectURL, click = HTMLAnchorElement.prototype.click;
      let content, name;
      URL.createObjectURL = (blob) => {{ content = blob.text(); return make(blob); }};
      HTMLAnchorElement.prototype.click = function () {{ name = this.download; }};
      [...document.querySelectorAll("#distance .save button")].find(one => one.textContent === "{kind}").click();
      URL.createObjectURL = make;
      HTMLAnchorElement.prototype.click = click;
      content.then((text) => done([name, text])); }})''') for kind in ('CSV', 'SVG')]
    (table, numbers), (picture, drawing) = saved
    assert table == 'distance_distance_1_to_2_s.csv'
    head, *rows = csv.reader(numbers.splitlines())
    assert head == ['time [s]', 'distance, <b>first</b> [cm]', f'distance, {SECOND} [cm]']
    assert (float(rows[0][0]), float(rows[-1][0])) == pytest.approx((1.0, 2.0), abs=0.011)
    time, value = next(row[:2] for row in rows if row[1])
    assert float(value) == pytest.approx(charts.evaluate(NEAREST.replace('TIME', time))[0], rel=1e-6)
    assert picture.endswith('.svg')
    drawn = ElementTree.fromstring(drawing)  # noqa: S314 (our own)
    words = [one.text for one in drawn.iter('{http://www.w3.org/2000/svg}text')]
    assert {'distance [cm]', '<b>first</b>', '1.8'} <= set(words)
    lines = [one.get('d') for one in drawn.iter('{http://www.w3.org/2000/svg}path') if one.get('clip-path')]
    assert [line.count('L') > 50 for line in lines] == [True, True]


def test_a_link_leads_to_its_time_the_bar_plays_in_sight_and_events_are_marked(browser, tmp_path):
    single, evaluate = write(tmp_path, 'single', start=(1.0, 0.0, 1.57), limit=2.0), browser.evaluate
    browser.show(single, DESKTOP)
    assert evaluate('[...document.querySelectorAll(".time-bar")].map(bar => [...bar.querySelectorAll(".mark")]'
                    '.map(mark => [mark.style.left, mark.title]))') == 2 * [[
                        ['25%', '1.00 s: backstepping.p = 2.5'], ['62.5%', '2.50 s: controller_type = "fuzzy"']]]
    # a dotted column of the canvas at the time of an event, and none beside it
    marked, beside = evaluate('''(() => {
      const canvas = document.querySelector("#energy canvas"), pen = canvas.getContext("2d");
      const over = document.querySelector("#energy .u-over"), box = canvas.getBoundingClientRect();
      return [1.0, 1.5].map(time => {
        const place = over.getBoundingClientRect(), x = Math.round(place.left - box.left + time / 4 * place.width);
        const data = pen.getImageData(x - 1, 20, 3, 60).data;
        return data.filter((value, n) => n % 4 === 0 && data[n + 3] > 100 && value < 150).length; }); })()''')
    assert marked > beside + 10
    told = evaluate('document.querySelector("#events").textContent + document.querySelector(".answer").textContent')
    for part in ('backstepping0.00 to 2.50 s', 'fuzzy2.50 to 4.00 s', 'a run of 2 laws', '; 2 events have changed it'):
        assert part in told
    # the slider enlarges the error, and its default shows it
    canvas, factor = 'document.querySelector(".deviation canvas").toDataURL()', 'document.querySelector(".factor {}")'
    assert evaluate(f'Number({factor.format("output")}.textContent)') > 1
    before = evaluate(canvas)
    evaluate('(slider => { slider.value = 0; slider.dispatchEvent(new Event("input")); })('
             + factor.format('input') + ')')
    wait_until(lambda: evaluate(canvas) != before, 30.0, 0.02)
    assert evaluate(f'{factor.format("output")}.textContent') == '1'
    browser.driver.get('about:blank')
    browser.driver.get(f'{single.as_uri()}#t=1.5')
    assert evaluate('mrc.clock.time') == 1.5
    assert evaluate('document.querySelector(".chart-bar .time").hash') == '#t=1.50'
    evaluate('(location.hash = "#t=2.25", 0)')
    wait_until(lambda: evaluate('mrc.clock.time') == 2.25, 30.0, 0.02)
    evaluate('document.querySelector("#energy").scrollIntoView()')
    assert 0 <= evaluate('document.querySelector(".chart-bar .play").getBoundingClientRect().top') < 60
    small = 'document.querySelector(".chart-bar canvas").toDataURL()'
    before, scrolled = evaluate(f'[{small}, scrollY]')
    ActionChains(browser.driver).send_keys(Keys.SPACE).perform()
    wait_until(lambda: evaluate('mrc.clock.time') > 2.3, 30.0, 0.02)
    assert evaluate(small) != before
    assert evaluate('scrollY') == scrolled
