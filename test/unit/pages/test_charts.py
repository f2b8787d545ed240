"""The charts of a report in a real browser: values under the pointer, one range, one cursor, switches, the slider."""

import csv
from xml.etree import ElementTree

import pytest
from measuring import configuration
from processes import wait_until

from mobile_robot_control.pages import report_writing
from mobile_robot_control.runs.run import Event, Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.simulation.rollout import rollout

PHONE, DESKTOP = 360, 1280
DURATION = 4.0
CHARTS = 'document.querySelectorAll(".chart .uplot").length'
# at a time on the charts, values as the legend of each chart has them
LEGEND = '[...document.querySelectorAll("#FIGURE .legend .value")].map(value => value.textContent)'
# colours in the middle of a chart's canvas
INKED = '''(() => { const canvas = document.querySelector("#FIGURE canvas"), pen = canvas.getContext("2d");
  const found = new Set(), data = pen.getImageData(0, 0, canvas.width, canvas.height).data;
  for (let n = 0; n < data.length; n += 4) if (data[n + 3] === 255) found.add([...data.slice(n, n + 3)].join());
  return [...found]; })()'''
SMALL = '''[...document.querySelectorAll(".charts *, .chart-bar *, .contents *")].filter(
  element => element.textContent.trim() && parseFloat(getComputedStyle(element).fontSize) < 12).length'''
WIDE = '''[...document.querySelectorAll("body *")].filter(element => !element.closest(".scroll, pre") &&
  element.getClientRects().length && element.getBoundingClientRect().right > innerWidth + 1).map(one => one.tagName)'''
SHOWN = '''[[...document.querySelectorAll("figure img")].filter(one => one.getClientRects().length).length,
  [...document.querySelectorAll(".chart")].filter(one => one.getClientRects().length).length > 0]'''
EVENTS = (Event(1.0, 'position_controller', {'backstepping.p': 2.5}),
          Event(2.5, 'position_controller', {'controller_type': 'fuzzy'}))
BLUE, ORANGE, LIMIT = '0,114,178', '213,94,0', '138,75,0'
BLUE_ON_DARK = '86,180,233'


def of(expression, figure):
    """An expression for one figure."""
    return expression.replace('FIGURE', figure)


@pytest.fixture(scope='module', autouse=True)
def still():
    """Write no pictures: these tests look at charts."""
    with pytest.MonkeyPatch.context() as patch:
        picture = '<svg xmlns="http://www.w3.org/2000/svg" width="4" height="3"/>'
        patch.setattr(report_writing, 'draw_and_save', lambda *_: picture)
        yield


def write(folder, *names, start=(1.1, 0.0, 1.2), limit=0.5):
    laws = ('backstepping', 'fuzzy')
    runs = []
    for name, law in zip(names, laws, strict=False):
        parameters = configuration(position_controller={'controller_type': law},
                                   plant={'initial_pose': list(start), 'max_wheel_torque': limit})
        series = collect(rollout(parameters, DURATION))
        runs.append(Run(name, series, (), {'duration': DURATION}, parameters, {}, EVENTS))
    return report_writing.write_report(runs, folder, lambda _: None)


@pytest.fixture(scope='module')
def pair(tmp_path_factory):
    return write(tmp_path_factory.mktemp('pair'), '<b>first</b>', 'a_second_run_with_a_name_of_some_length')


@pytest.fixture(scope='module')
def single(tmp_path_factory):
    return write(tmp_path_factory.mktemp('single'), 'single', start=(1.0, 0.0, 1.57), limit=2.0)


@pytest.fixture
def charts(browser, pair):
    browser.show(pair, DESKTOP)
    return browser


def drag(browser, figure, fractions, kind='mouseMoved'):
    """Move the pointer over the first chart of a figure, to fractions of its width; pressed between the first two."""
    browser.evaluate(f'document.querySelector("#{figure} .u-over").scrollIntoView({{block: "center"}})')
    box = browser.evaluate(f'(() => {{ const box = document.querySelector("#{figure} .u-over").getBoundingClientRect();'
                           'return [box.left, box.top, box.width, box.height]; })()')
    left, top, width, height = box
    points = [(left + fraction * width, top + 0.5 * height) for fraction in fractions]
    for n, (x, y) in enumerate(points):
        browser.call('Input.dispatchMouseEvent', type='mouseMoved', x=x, y=y,
                     **({'button': 'left', 'buttons': 1} if n else {}))
        if n == 0 and len(points) > 1:
            browser.call('Input.dispatchMouseEvent', type='mousePressed', x=x, y=y, button='left', clickCount=1)
    if len(points) > 1:
        browser.call('Input.dispatchMouseEvent', type='mouseReleased', x=points[-1][0], y=points[-1][1], button='left',
                     clickCount=1)


def ranges(browser):
    """The ranges that the charts show, each once."""
    return browser.evaluate('[...new Set([mrc.charts.range.join()])][0].split(",").map(Number)')


def test_every_panel_is_a_chart_without_an_error_or_a_request(charts, pair):
    assert charts.evaluate(CHARTS) == sum(len(figure.panels) for figure in RUN_FIGURES)
    assert charts.errors() == []
    assert charts.requests() == [pair.as_uri()]
    # the name of a run is a text
    assert '<b>first</b>' in charts.evaluate('document.querySelector(".chart-bar .switch .name").textContent')
    assert charts.evaluate('document.querySelectorAll(".charts b, .chart-bar b").length') == 0
    # limits are drawn and named where there are torques
    assert 'limit ±0.5 N m' in charts.evaluate('document.querySelector("#torque .head").textContent')
    assert [LIMIT in charts.evaluate(of(INKED, figure)) for figure in ('torque', 'power')] == [True, False]
    assert charts.evaluate('[...document.querySelectorAll(".contents a")].map(one => one.hash.slice(1))') == [
        'metrics', 'events', 'figures', *(figure.name for figure in RUN_FIGURES), 'configuration']
    assert charts.evaluate(
        '[...document.querySelectorAll(".contents a")].every(one => document.querySelector(one.hash))')


def test_the_pointer_shows_values_with_units_at_its_time_in_all_charts(charts):
    drag(charts, 'distance', [0.5])
    wait_until(lambda: charts.evaluate('mrc.charts.hover') is not None, 30.0, 0.02)
    assert charts.evaluate('mrc.charts.hover') == pytest.approx(0.5 * DURATION, abs=0.05)
    expected = charts.evaluate('''mrc.charts.data.charts.find(chart => chart.figure === "distance").lines.filter(
      line => line.kind === "value").map(line => { const [times, values] = [line.time, line.value].map(
      place => mrc.charts.data.columns[place]); return values[mrc.nearest(times, mrc.charts.hover)]; })''')

    def shown():
        return [(text.split() + ['', ''])[:2] for text in charts.evaluate(of(LEGEND, 'distance'))]

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


def test_a_click_or_play_sets_the_clock_and_the_clock_moves_the_cursor_of_every_chart(charts):
    drag(charts, 'errors', [0.25, 0.25])
    assert charts.evaluate('mrc.clock.time') == pytest.approx(0.25 * DURATION, abs=0.05)
    places = '''[...document.querySelectorAll(".now")].map(mark => parseFloat(mark.style.transform.slice(11))
      / mark.parentElement.clientWidth)'''
    charts.evaluate('mrc.clock.set(3)')
    charts.evaluate('document.querySelector("#errors").scrollIntoView()')
    there = f'{places}.filter(place => Math.abs(place - 0.75) < 0.01).length'
    wait_until(lambda: charts.evaluate(there) > 3, 30.0, 0.02)
    charts.evaluate('(mrc.charts.hover = null, mrc.clock.play())')
    wait_until(lambda: charts.evaluate('mrc.clock.time') > 3.1, 20.0, 0.02)
    charts.evaluate('mrc.clock.pause()')
    assert charts.evaluate(f'Math.max(...{places})') > 0.76


def test_dragging_zooms_every_chart_and_a_double_click_shows_the_whole_run(charts):
    drag(charts, 'errors', [0.25, 0.4, 0.5])
    wait_until(lambda: charts.evaluate('mrc.charts.zoomed'), 30.0, 0.02)
    assert ranges(charts) == pytest.approx([0.25 * DURATION, 0.5 * DURATION], abs=0.05)
    # a drag is no click
    assert charts.evaluate('mrc.clock.time') == 0.0
    charts.evaluate('''document.querySelector("#velocity .u-over").dispatchEvent(
      new MouseEvent("dblclick", {bubbles: true}))''')
    assert ranges(charts) == [0.0, DURATION]
    # and by keyboard
    plus, whole = (f'[...document.querySelectorAll(".chart-bar button")].find(one => one.textContent === "{name}")'
                   for name in ('+', 'whole run'))
    charts.evaluate(f'{plus}.focus()')
    charts.call('Input.dispatchKeyEvent', type='keyDown', key='Enter', text='\r', windowsVirtualKeyCode=13)
    charts.call('Input.dispatchKeyEvent', type='keyUp', key='Enter', windowsVirtualKeyCode=13)
    wait_until(lambda: charts.evaluate('mrc.charts.zoomed'), 30.0, 0.02)
    assert not charts.evaluate(f'{whole}.disabled')
    charts.evaluate(f'{whole}.click()')
    assert ranges(charts) == [0.0, DURATION]


def test_a_run_is_switched_off_in_every_chart_by_its_name_and_others_are_shown_against_the_first(charts):
    assert {BLUE, ORANGE} <= set(charts.evaluate(of(INKED, 'distance')))
    charts.evaluate('document.querySelector("#errors .legend .switch").focus()')
    charts.call('Input.dispatchKeyEvent', type='keyDown', key=' ', text=' ', windowsVirtualKeyCode=32)
    charts.call('Input.dispatchKeyEvent', type='keyUp', key=' ', windowsVirtualKeyCode=32)
    for figure in ('distance', 'path', 'energy'):
        wait_until(lambda figure=figure: BLUE not in charts.evaluate(of(INKED, figure)), 30.0, 0.05)
        assert ORANGE in charts.evaluate(of(INKED, figure))
    assert charts.evaluate('document.querySelector(".chart-bar .switch").getAttribute("aria-pressed")') == 'false'
    charts.evaluate('document.querySelector(".chart-bar .switch").click()')
    wait_until(lambda: BLUE in charts.evaluate(of(INKED, 'distance')), 30.0, 0.05)
    # differences of the other runs to the first are in place of their values
    charts.evaluate('document.querySelector("#distance").scrollIntoView()')
    charts.evaluate('[...document.querySelectorAll(".chart-bar button")].pop().click()')
    wait_until(lambda: BLUE not in charts.evaluate(of(INKED, 'distance')), 30.0, 0.05)
    assert ORANGE in charts.evaluate(of(INKED, 'distance'))
    wait_until(lambda: charts.evaluate(of(LEGEND, 'distance'))[0] == 'first', 30.0, 0.05)


def test_events_are_marked_on_every_bar_of_time_and_in_every_chart(browser, single):
    browser.show(single, DESKTOP)
    assert browser.evaluate('[...document.querySelectorAll(".time-bar")].map(bar => [...bar.querySelectorAll(".mark")]'
                            '.map(mark => [mark.style.left, mark.title]))') == 2 * [[
        ['25%', '1.00 s: backstepping.p = 2.5'], ['62.5%', '2.50 s: controller_type = "fuzzy"']]]
    # a dotted column of the canvas at the time of an event, and none beside it
    inked = '''(() => { const canvas = document.querySelector("#energy canvas"), pen = canvas.getContext("2d");
      const over = document.querySelector("#energy .u-over"), box = canvas.getBoundingClientRect();
      return [1.0, 1.5].map(time => {
        const place = over.getBoundingClientRect(), x = Math.round(place.left - box.left + time / 4 * place.width);
        const data = pen.getImageData(x - 1, 20, 3, 60).data;
        let count = 0;
        for (let n = 0; n < data.length; n += 4) count += data[n + 3] > 100 && data[n] < 150;
        return count; }); })()'''
    marked, beside = browser.evaluate(inked)
    assert marked > beside + 10
    text = browser.evaluate('document.querySelector("#events").textContent')
    assert 'backstepping0.00 to 2.50 s' in text
    assert 'fuzzy2.50 to 4.00 s' in text
    assert 'a run of 2 laws' in browser.evaluate('document.querySelector(".answer").textContent')
    assert '; 2 events have changed it' in browser.evaluate('document.querySelector(".answer").textContent')


def test_a_link_leads_to_its_time_and_the_bar_plays_in_sight(browser, single):
    browser.driver.get('about:blank')
    browser.driver.get(f'{single.as_uri()}#t=1.5')
    assert browser.evaluate('mrc.clock.time') == 1.5
    assert browser.evaluate('document.querySelector(".chart-bar .time").hash') == '#t=1.50'
    browser.evaluate('(location.hash = "#t=2.25", 0)')
    wait_until(lambda: browser.evaluate('mrc.clock.time') == 2.25, 30.0, 0.02)
    browser.evaluate('document.querySelector("#energy").scrollIntoView()')
    top = browser.evaluate('document.querySelector(".chart-bar .play").getBoundingClientRect().top')
    assert 0 <= top < 60
    small = 'document.querySelector(".chart-bar canvas").toDataURL()'
    before, scrolled = browser.evaluate(f'[{small}, scrollY]')
    browser.call('Input.dispatchKeyEvent', type='keyDown', key=' ', text=' ', windowsVirtualKeyCode=32)
    wait_until(lambda: browser.evaluate('mrc.clock.time') > 2.3, 30.0, 0.02)
    assert browser.evaluate(small) != before
    assert browser.evaluate('scrollY') == scrolled
    browser.evaluate('mrc.clock.pause()')


def test_a_run_is_hidden_in_the_plane_and_the_plane_is_zoomed_and_dragged(charts):
    plane = 'document.querySelector("#replay canvas").toDataURL()'
    charts.evaluate('mrc.clock.set(2)')
    before = charts.evaluate(plane)
    charts.evaluate('document.querySelector("#replay .switch").click()')
    hidden = charts.evaluate(plane)
    assert hidden != before
    assert charts.evaluate('[...mrc.charts.off]').count('run 0') == 1
    charts.evaluate('document.querySelector("#replay .switch").click()')
    assert charts.evaluate(plane) == before
    charts.evaluate('document.querySelector("#replay button[title^=\'Zoom into\']").click()')
    zoomed = charts.evaluate(plane)
    assert zoomed != before
    charts.evaluate('mrc.replay.scene.pan(40, 10)')
    assert charts.evaluate(plane) not in (zoomed, before)
    charts.evaluate('document.querySelector("#replay button[title^=\'Zoom out\']").click()')
    assert charts.evaluate(plane) == before


def test_what_a_chart_shows_is_saved_as_numbers_and_as_a_drawing(charts):
    charts.evaluate('mrc.charts.setRange(1, 2)')
    saved = {}
    for kind in ('CSV', 'SVG'):
        saved[kind] = charts.evaluate(f'''new Promise((done) => {{
          const make = URL.createObjectURL, click = HTMLAnchorElement.prototype.click;
          let content, name;
          URL.createObjectURL = (blob) => {{ content = blob.text(); return make(blob); }};
          HTMLAnchorElement.prototype.click = function () {{ name = this.download; }};
          [...document.querySelectorAll("#distance .save button")].find(one => one.textContent === "{kind}").click();
          URL.createObjectURL = make;
          HTMLAnchorElement.prototype.click = click;
          content.then((text) => done([name, text])); }})''')
    name, text = saved['CSV']
    assert name == 'distance_distance_1_to_2_s.csv'
    head, *rows = csv.reader(text.splitlines())
    assert head == ['time [s]', 'distance, <b>first</b> [cm]', 'distance, a_second_run_with_a_name_of_some_length [cm]']
    assert (float(rows[0][0]), float(rows[-1][0])) == pytest.approx((1.0, 2.0), abs=0.011)
    place = next(n for n, row in enumerate(rows) if row[1])
    expected = charts.evaluate('''(() => { const line = mrc.charts.data.charts.find(
      chart => chart.figure === "distance").lines.find(one => one.kind === "value"), {columns} = mrc.charts.data;
      return columns[line.value][mrc.nearest(columns[line.time], ''' + rows[place][0] + ')]; })()')
    assert float(rows[place][1]) == pytest.approx(expected, rel=1e-6)
    name, text = saved['SVG']
    assert name.endswith('.svg')
    drawn = ElementTree.fromstring(text)  # noqa: S314 (our own)
    words = [one.text for one in drawn.iter('{http://www.w3.org/2000/svg}text')]
    assert {'distance [cm]', '<b>first</b>', '1.8'} <= set(words)
    lines = [one.get('d') for one in drawn.iter('{http://www.w3.org/2000/svg}path') if one.get('clip-path')]
    assert len(lines) == 2
    assert all(line.count('L') > 50 for line in lines)


def test_the_slider_enlarges_the_error_and_its_default_shows_it(browser, single):
    browser.show(single, DESKTOP)
    slider = 'document.querySelector(".factor input")'
    assert browser.evaluate('Number(document.querySelector(".factor output").textContent)') > 1
    canvas = 'document.querySelector(".deviation canvas").toDataURL()'
    before = browser.evaluate(canvas)
    browser.evaluate(f'(({slider}).value = 0, ({slider}).dispatchEvent(new Event("input")))')
    wait_until(lambda: browser.evaluate(canvas) != before, 30.0, 0.02)
    assert browser.evaluate('document.querySelector(".factor output").textContent') == '1'


@pytest.mark.parametrize('width', [PHONE, DESKTOP])
def test_nothing_overflows_no_label_is_small_and_charts_turn_dark_with_the_page(browser, pair, width):
    browser.show(pair, width)
    assert browser.evaluate('document.documentElement.scrollWidth - document.documentElement.clientWidth') == 0
    assert (browser.evaluate(WIDE), browser.evaluate(SMALL), browser.errors()) == ([], 0, [])
    assert BLUE in browser.evaluate(of(INKED, 'distance'))
    browser.media('', 'dark')
    wait_until(lambda: BLUE_ON_DARK in browser.evaluate(of(INKED, 'distance')), 30.0, 0.05)


def test_pictures_are_shown_on_paper_and_without_scripts_and_charts_on_a_screen(browser, pair):
    browser.show(pair, DESKTOP, scripts=False)
    assert browser.evaluate(SHOWN) == [len(RUN_FIGURES), False]
    browser.show(pair, DESKTOP)
    assert browser.evaluate(SHOWN) == [0, True]
    browser.media('print', 'dark')
    assert browser.evaluate(SHOWN) == [len(RUN_FIGURES), False]
    # paper is light
    assert browser.evaluate('getComputedStyle(document.body).backgroundColor') == 'rgb(255, 255, 255)'
