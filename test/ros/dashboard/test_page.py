"""The live page in a browser: what is changed there changes in the nodes, and what is refused is shown in words."""

import json
import os
import re
import signal
from pathlib import Path

import pytest
from helpers.live_page import PLUGINS, Lesson, OpenPage
from helpers.processes import wait_until
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select

from mobile_robot_control.messages.bag_files import read_loop_messages
from mobile_robot_control.parameters.plugins import load_plugins
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.topics import POSITION_TOPICS

P = 'backstepping.p'
OPEN_ALL = 'document.querySelectorAll("#live details").forEach((one) => { one.open = true; })'


def _drag(page, live, row, right):
    """Drag the slider of a parameter to the right; return the value that it has then, once the node has it."""
    slider = row.find_element('css selector', 'input[type=range]')
    ActionChains(page.driver).drag_and_drop_by_offset(slider, right, 0).perform()
    page.settle()
    value = float(slider.get_attribute('value'))
    page.wait(lambda: abs(live.asker.value('/position_controller', P) - value) < 1e-9)
    return live.asker.value('/position_controller', P)


def test_controls_change_parameters_and_are_taken_back(page, live):
    row = page.parameter(P)
    default = live.asker.value('/position_controller', P)
    assert _drag(page, live, row, 60) > default + 0.1
    page.wait(lambda: 'changed' in row.get_attribute('class'))
    page.click(row.find_element('css selector', '.back'))
    page.wait(lambda: live.asker.value('/position_controller', P) == default)
    page.wait(lambda: 'changed' not in row.get_attribute('class'))
    page.type_into(row.find_element('css selector', 'input[type=text]'), '1,75')
    page.wait(lambda: live.asker.value('/position_controller', P) == 1.75)
    page.choose('law', 'fuzzy')
    start = page.parameter('initial_pose', 'plant').find_element('css selector', 'input')
    page.type_into(start, '1.5, 0.5, 0')
    page.wait(lambda: live.asker.value('/plant', 'initial_pose')[0] == 1.5)
    page.settle()
    page.click(page.find('#defaults'))
    page.wait(lambda: live.asker.value('/position_controller', 'controller_type') == 'backstepping')
    page.wait(lambda: live.asker.value('/plant', 'initial_pose')[0] == pytest.approx(1.0))
    page.wait(lambda: live.asker.value('/position_controller', P) == default)


def test_a_velocity_law_is_chosen_and_its_arrays_of_gains_have_sliders(page, live):
    def gains():
        return live.asker.value('/velocity_controller', 'computed_torque.k')

    page.choose('velocity-law', 'computed_torque')
    page.wait(lambda: live.asker.value('/velocity_controller', 'controller_type') == 'computed_torque')
    groups = 'details[data-group="velocity_controller/{}"]'
    page.wait(lambda: page.find(groups.format('computed_torque')).get_attribute('open'))
    assert not page.find(groups.format('gains')).get_attribute('open')
    row = page.parameter('computed_torque.k', 'velocity_controller')
    first, second = row.find_elements('css selector', 'input[type=range]')
    ActionChains(page.driver).drag_and_drop_by_offset(second, 60, 0).perform()
    page.wait(lambda: gains()[1] > 10.1)
    page.settle()
    page.wait(lambda: gains() == pytest.approx((10.0, float(second.get_attribute('value')))))
    assert float(first.get_attribute('value')) == 10.0
    page.click(page.find('#defaults'))
    page.wait(lambda: live.asker.value('/velocity_controller', 'controller_type') == 'pi')
    page.wait(lambda: list(gains()) == [10.0, 10.0])


def test_a_refusal_has_the_words_of_the_node(page):
    field = page.parameter(P).find_element('css selector', 'input[type=text]')
    before = field.get_attribute('value')
    for text in ('-1', 'Infinity', 'nonsense <b>bold</b>'):
        page.type_into(field, text)
        page.wait(lambda text=text: text in page.words(P))
        page.wait(lambda: field.get_attribute('value') == before)
    assert 'must be above 0.0' in page.words(P) or 'write a number' in page.words(P)
    assert not page.driver.find_elements('css selector', '#parameters b b')


def test_a_law_comes_with_its_shipped_gains_is_undone_and_leaves_what_the_user_has_set(page, live):
    def gains():
        return tuple(live.asker.value(*one) for one in (
            ('/position_controller', 'fuzzy.a'), ('/velocity_controller', 'gains.k1')))

    default = gains()
    page.wait(lambda: page.text('gains') == 'shipped gains')
    page.choose('law', 'fuzzy')
    page.wait(lambda: gains() == (0.0523369, 0.498752))
    page.click(page.find('#undo-law'))
    page.wait(lambda: gains() == default)
    page.wait(lambda: page.find('#law').get_attribute('value') == 'backstepping')
    page.wait(lambda: not page.find('#undo-law').is_displayed())
    page.type_into(page.parameter('fuzzy.a').find_element('css selector', 'input[type=text]'), '0.3')
    page.wait(lambda: gains() == (0.3, default[1]))
    page.choose('law', 'fuzzy')
    page.wait(lambda: page.text('gains') == 'changed gains')
    assert gains() == (0.3, 0.498752)
    page.click(page.find('#ship'))
    page.wait(lambda: page.text('gains') == 'shipped gains')
    assert gains() == (0.0523369, 0.498752)
    page.click(page.find('#defaults'))
    page.wait(lambda: gains() == default and not page.find('#undo-law').is_displayed())


def test_another_law_runs_and_its_file_is_read_again_with_errors_told_by_their_line(page, live):
    text = live.law.read_text()
    page.choose('law', 'my_kanayama')
    page.wait(lambda: live.asker.value('/position_controller', 'controller_type') == 'my_kanayama')
    assert 'longitudinal gain' in page.parameter('my_kanayama.p').text
    page.wait(lambda: 'Lyapunov' not in page.find('#charts').text)
    assert not page.find('#read-law').is_displayed()
    try:
        live.law.write_text(text + '\ndef broken(:\n')
        page.click(page.find('#read-law'))
        page.wait(lambda: f'line {len(text.splitlines()) + 2}' in page.text('notice'))
        page.find('#close-notice').click()
        assert not page.find('#notice').is_displayed()
        live.law.write_text(text.replace('def step(state, observation, gains, dt):',
                                         'def step(state, observation, gains, dt):\n    raise ValueError("late")'))
        page.click(page.find('#read-law'))
        page.wait(lambda: 'law_file = "my_kanayama ' in page.text('changes'))
        page.wait(lambda: f'law failed: ValueError: late in {live.law}, line ' in page.text('notice'))
    finally:
        live.law.write_text(text)
    page.click(page.find('#read-law'))
    page.wait(lambda: page.text('nodes').count('running') == 4 and not page.find('#notice').is_displayed())
    page.choose('law', 'backstepping')
    page.wait(lambda: 'Lyapunov' in page.find('#charts').text)
    page.wait(lambda: page.find('details[data-group="position_controller/backstepping"]').get_attribute('open'))


def test_a_node_that_was_killed_is_started_again(page, live):
    page.choose('speed', '1')
    number, = (pid for pid in live.nodes() if b'reference_cart' in Path(f'/proc/{pid}/cmdline').read_bytes())
    os.kill(number, signal.SIGKILL)
    page.wait(lambda: 'was killed by SIGKILL' in page.text('notice'))
    held = page.number('time')
    page.wait(lambda: page.driver.execute_script(
        'const button = document.querySelector(`#nodes [data-role="reference_cart"] button`); '
        'if (button) button.focus(); return Boolean(button)'))
    page.keys_here(Keys.ENTER)
    page.wait(lambda: page.number('time') > held + 0.2 and not page.find('#notice').is_displayed())


def test_another_curve_begins_a_new_run_at_its_start(page):
    run = page.number('run')
    page.driver.execute_script('document.querySelector("#curve details").open = true')
    for curve, right in (('ellipse', [1.0, 0.5]), ('trifolium', [1.0, 0.88])):
        Select(page.find('#curve [data-parameter="curve"] select')).select_by_value(curve)
        page.wait(lambda run=run: page.number('run') > run)
        run = page.number('run')
        page.wait(lambda right=right: page.driver.execute_script(
            'return ["x", "y"].map((name) => Math.max(...mrc.stage.path()[name]))') == pytest.approx(right, abs=0.02))
        page.wait(lambda: abs(page.number('e1')) + abs(page.number('e2')) < 0.1)


def test_space_holds_the_run_for_single_steps_and_pushes_until_it_is_pressed_again(page, live):
    page.hold()
    page.wait(lambda: 'paused' in page.text('nodes'))
    # the answer has the time of the plant, which the page's last row may not have reached yet
    answer = page.driver.execute_async_script('mrc.live.ask({do: "step"}).then(arguments[0])')
    held = float(re.fullmatch(r'time goes on to t = ([\d.]+) s', answer['text'])[1])
    page.wait(lambda: page.number('time') == pytest.approx(held, abs=1e-4))
    page.find('#step').click()
    page.wait(lambda: page.number('time') > held + 0.001)
    assert page.number('time') == pytest.approx(held + 0.01, abs=1e-4)
    canvas = page.find('#scene')
    for key, column, least in ((Keys.ARROW_LEFT, 'angular', 0.5), (Keys.ARROW_UP, 'linear', 0.1)):
        held, pushes = page.number(column), page.text('changes').count('disturbance')
        seen = []
        canvas.click()
        canvas.send_keys(key)

        def is_pushed(pushes=pushes, column=column, seen=seen):
            # the push acts on the next step, and the controllers bring the robot back in those after it
            before = page.number('time')
            page.find('#step').click()
            page.wait(lambda: page.number('time') > before)
            seen.append(page.number(column))
            return page.text('changes').count('disturbance') > pushes

        page.wait(is_pushed)
        page.wait(lambda held=held, column=column, least=least, seen=seen: (
            max(*seen, page.number(column)) > held + least))
    held = page.number('time')
    page.keys(' ')
    page.wait(lambda: page.number('time') > held + 0.1)


def test_r_begins_a_new_run_and_a_dragged_start_is_taken(page, live):
    page.choose('speed', '1')
    page.wait(lambda: page.number('time') > 1.0)
    run = page.number('run')
    page.keys('r')
    page.wait(lambda: page.number('run') > run)
    highest = 'return Math.max(...mrc.stage.path().y)'
    page.wait(lambda: page.driver.execute_script(highest) == pytest.approx(0.88, abs=0.02))
    page.find('#place').click()
    # drawn once more, the plane stays where it is
    x, y = page.driver.execute_async_script(
        'requestAnimationFrame(() => requestAnimationFrame(() => arguments[0](mrc.stage.toScreen(0.5, 0.8))))')
    canvas = page.find('#scene')
    size = canvas.size
    (ActionChains(page.driver).move_to_element_with_offset(canvas, x - size['width'] / 2, y - size['height'] / 2)
     .click_and_hold().move_by_offset(60, 0).release().perform())
    page.wait(lambda: live.asker.value('/plant', 'initial_pose')[0] == pytest.approx(0.5, abs=0.05))
    assert list(live.asker.value('/plant', 'initial_pose')[1:]) == pytest.approx([0.8, 0.0], abs=0.05)
    # the same by keys and by numbers
    page.find('#place').click()
    before = live.asker.value('/plant', 'initial_pose')[0]
    x = float(page.find('#placing [name=x]').get_attribute('value'))
    page.keys_here(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ENTER)
    page.wait(lambda: live.asker.value('/plant', 'initial_pose')[0] != before)
    assert live.asker.value('/plant', 'initial_pose')[0] == pytest.approx(x + 0.1, abs=0.01)
    page.find('#place').click()
    page.type_into(page.find('#placing [name=y]'), '0,25')
    page.wait(lambda: live.asker.value('/plant', 'initial_pose')[1] == 0.25)


def test_the_speed_is_changed_and_measured(page, live):
    page.choose('speed', '0.1')
    page.wait(lambda: live.asker.value('/plant', 'real_time_factor') == 0.1)
    page.wait(lambda: page.number('speed') == pytest.approx(0.1, abs=0.05))
    page.choose('speed', '1')
    page.wait(lambda: live.asker.value('/plant', 'real_time_factor') == 1.0)
    # how much faster depends on the machine
    page.wait(lambda: page.number('speed') > 0.16)


def test_what_one_browser_changes_another_one_shows(page, live):
    first = page.driver.current_window_handle
    page.driver.switch_to.new_window('window')
    other = OpenPage(page.browser, live.address)
    field = other.parameter('backstepping.g').find_element('css selector', 'input[type=text]')
    other.type_into(field, '9.5')
    other.wait(lambda: live.asker.value('/position_controller', 'backstepping.g') == 9.5)
    page.driver.close()
    page.driver.switch_to.window(first)
    shown = page.parameter('backstepping.g').find_element('css selector', 'input[type=text]')
    page.wait(lambda: shown.get_attribute('value') == '9.5')


def test_the_run_goes_on_while_no_page_is_open(page, live):
    begun = page.number('time')
    page.driver.get('about:blank')
    wait_until(lambda: live.process.poll() is None and len(live.nodes()) == 4)
    again = OpenPage(page.browser, live.address)
    page.wait(lambda: again.number('time') > begun)


def test_a_recording_ends_in_a_report_and_the_parameters_are_saved_for_every_node(page, live, registered):
    page.choose('speed', '1')
    page.wait(lambda: page.number('time') > 1.0)
    page.find('#record').click()
    page.wait(lambda: page.find('#record').text == 'Stop recording' and page.find('#record').is_enabled())
    recorded, = (live.folder / 'recordings').glob('*/bag/*.mcap')
    page.wait(lambda: recorded.stat().st_size > 50_000)
    dragged = _drag(page, live, page.parameter(P), 40)
    page.wait(lambda: f'{P} = {dragged}' in page.text('changes'))
    # what is recorded is written twice a second
    page.wait(lambda: f'{P} = {dragged}'.encode() in recorded.read_bytes())
    page.choose('speed', '0.1')
    page.find('#save').click()
    page.wait(lambda: page.text('saved').startswith('parameters_'))
    load_plugins({'law': [str(PLUGINS / 'kanayama.py')], 'curve': [str(PLUGINS / 'ellipse.py')]})
    assert load([live.folder / 'saved' / page.text('saved')]).keys() == set(NODES)
    page.find('#record').click()
    page.wait(lambda: page.driver.find_elements('css selector', '#recorded a'))
    changes = read_loop_messages(recorded.parent, '/', ()).changes
    assert ('position_controller', {P: dragged}) in [(change.node, change.values) for change in changes], changes
    page.click(page.parameter(P).find_element('css selector', '.back'))
    # a recording begun late is whole, and counts from its beginning
    metrics = json.loads((recorded.parents[1] / 'metrics.json').read_text())
    courses = read_loop_messages(recorded.parent, '/', POSITION_TOPICS).courses.values()
    first, last = (choose(course.stamps[n] for course in courses) / 1e9 for choose, n in ((max, 0), (min, -1)))
    assert first > 1.0
    assert metrics['outcome'] == 'recorded'
    assert metrics['duration'] == pytest.approx(last - first, abs=0.1)
    # in one step: the page makes the link again with each state that it shows
    report = page.driver.execute_script('return document.querySelector("#recorded a").href')
    # a further one does not hide it
    assert page.driver.execute_script(
        'mrc.live.state({nodes: [], unreadable: {}, events: [], ended: {}, changed_laws: [], lesson: "", name: "", '
        'recordings: [{state: "done", name: "recording_1"}, {state: "recording", name: "recording_2"}]});'
        'return document.querySelectorAll("#recorded a").length + document.getElementById("recorded").textContent'
    ) == '1recording_2 …  report of recording_1 '
    page.driver.get(report)
    assert 'was recorded for' in page.find('body').text
    shown = page.find('body').text
    assert 'is not complete' not in shown, shown.partition('What is missing')[2][:400]


def test_a_lost_connection_goes_on_where_it_was(page):
    # messages on their way are lost, as where a network fails; the page shows it for a second
    page.driver.execute_script(
        'window.kept = true; window.former = mrc.socket; window.shown = "";'
        'const run = document.getElementById("run");'
        'mrc.live.on("connection", (open) => { if (!open) window.shown = run.textContent; });'
        'mrc.socket.close()')
    page.wait(lambda: page.driver.execute_script('return window.shown').startswith('no connection'))
    page.wait(lambda: page.driver.execute_script('return mrc.socket !== window.former && mrc.socket.readyState === 1'))
    before = page.text('run')
    page.wait(lambda: page.text('run') != before)
    assert page.driver.execute_script('return window.kept')


def test_a_request_whose_answer_is_lost_is_answered_in_words(page):
    answer = page.driver.execute_async_script(
        'const later = window.setTimeout; window.setTimeout = (act) => later(act, 0);'
        'WebSocket.prototype.send = () => {}; mrc.live.ask({do: "record"}).then(arguments[0])')
    assert answer == {'good': False, 'text': 'the server of this page gave no answer; load the page again'}


def test_texts_of_the_graph_are_shown_as_text(page, live):
    text = '<img src=x onerror="document.title=1"><b>bold</b>'

    def is_shown():
        live.asker.report(text)
        return text in page.text('nodes')

    page.wait(is_shown)
    assert not page.driver.find_elements('css selector', '#nodes img, #nodes b b')


def test_nothing_overflows_on_any_ground_and_a_screen_reader_finds_its_way(page, live):
    # which line belongs to which axis
    errors = page.find('figure[data-chart="errors"] figcaption').text
    assert 'e2 to the left [m]' in errors
    assert 'e3 heading [rad, right axis]' in errors
    page.driver.execute_script(OPEN_ALL)
    page.wait(lambda: 'geometry_msgs' in page.text('topics'))
    assert page.browser.violations() == []
    for width, scheme in ((360, 'light'), (360, 'dark'), (1280, 'dark')):
        page.browser.call('Emulation.setDeviceMetricsOverride', width=width, height=700, deviceScaleFactor=1,
                          mobile=width < 600)
        page.browser.media('', scheme)
        # drawn once more, charts have the new width
        page.driver.execute_async_script('requestAnimationFrame(() => requestAnimationFrame(() => arguments[0]()))')
        over = page.driver.execute_script(
            'return [...document.querySelectorAll("#live *")].filter((one) => !one.closest(".scroll") && '
            '!one.closest(".u-wrap") && one.getBoundingClientRect().right > arguments[0] + 1)'
            '.map((one) => one.outerHTML)', width)
        assert not over
        assert page.driver.execute_script('return document.documentElement.scrollWidth') <= width
        ground = page.driver.execute_script('return getComputedStyle(document.getElementById("live")).backgroundColor')
        assert ground == ('rgb(255, 255, 255)' if scheme == 'light' else 'rgb(21, 24, 28)')
    lesson = Lesson(page, '1_errors')
    assert page.browser.violations() == []
    lesson.close()
