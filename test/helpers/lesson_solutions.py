"""How each shipped lesson is passed, by keyboard alone: a wrong answer first, then the right one."""

import math
import re

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from helpers.live_page import Lesson

SLOW = 0.2
"""Simulated time per wall time while nothing is measured: the robot leaves time for other tests."""
SIZES = {'desktop': (1280, 800), 'phone': (390, 844)}


def _drive(page, factor):
    """Let so much simulated time pass per wall time."""
    page.driver.execute_script(f'mrc.live.set("plant", {{real_time_factor: {factor}}})')
    page.settle()


def begin(page, name, size):
    """Begin a lesson at a size; all that it needs is in view."""
    width, height = SIZES[size]
    page.browser.call('Emulation.setDeviceMetricsOverride', width=width, height=height, deviceScaleFactor=1,
                      mobile=size == 'phone')
    run, lesson = page.number('run'), Lesson(page, name)
    # one that is reset before its first step is the same run
    page.wait(lambda: page.number('run') > run or page.number('time') < 0.5)
    page.wait(lambda: not lesson.hidden(), look=lesson.hidden)
    violations = page.browser.violations()
    assert not violations, violations
    _drive(page, SLOW)
    return lesson


def draw_and_send(page, by_pointer=False):
    """Draw a path and send it, by keyboard alone or by pointer."""
    scene = page.find('#scene')
    page.driver.execute_script('arguments[0].scrollIntoView()', scene)
    draw, send = (next(one for one in page.find('#path').find_elements('css selector', 'button') if one.text == text)
                  for text in ('Draw', 'Send'))
    if by_pointer:
        draw.click()
        for right, down in ((-60, 0), (20, -60), (80, 30)):
            ActionChains(page.driver).move_to_element_with_offset(scene, right, down).click().perform()
    else:
        draw.send_keys(Keys.ENTER)
        page.keys_here(Keys.ENTER, *[Keys.ARROW_LEFT] * 8, Keys.ENTER, *[Keys.ARROW_UP] * 6, Keys.ENTER)
    page.wait(lambda: 'Active limits' in page.text('path-words'))
    page.wait(send.is_enabled)
    if by_pointer:
        send.click()
    else:
        send.send_keys(Keys.ENTER)
    page.wait(lambda: page.text('path-words') == 'The cart follows it.')


def _measured(text):
    return re.search(r'Measured: ([\d.]+)', text)[1]


def _go_from_the_start(page, begin_run, until, look=lambda: '', early='', factor=1.0):
    """Hold the run, begin a new one, and let it go to a time [s]: a page that is slow has seen its start, too."""
    page.hold()
    run = page.number('run')
    begin_run()
    page.wait(lambda: page.number('run') > run and page.number('time') == 0.0)
    assert early in look()
    _drive(page, factor)
    page.keys(' ')
    page.wait(lambda: page.number('time') > until)
    _drive(page, SLOW)


def errors(page, lesson):
    """Place the robot beside the cart."""
    assert lesson.check().startswith('Not yet. It is e1 = ')
    lesson.move(0, *[Keys.ARROW_LEFT] * 4)
    page.wait(lambda: abs(page.number('e1') - 0.2) < 0.01)
    lesson.move(1, *[Keys.ARROW_RIGHT] * 2)
    page.wait(lambda: abs(page.number('e2') + 0.1) < 0.01)
    # a topic that was silent for a second has no number
    page.wait(lambda: lesson.check().startswith('Right'), look=lesson.verdict)


def gains(page, lesson):
    """Move the gains until the node refuses."""
    assert 'has taken 2 %' in lesson.check('50')
    for key in (Keys.PAGE_UP, Keys.PAGE_UP, Keys.PAGE_UP, *[Keys.ARROW_RIGHT] * 3):
        lesson.move(0, key)
        page.wait(lambda: page.driver.execute_script('return mrc.live.idle()'))
    page.wait(lambda: ' Hz' in lesson.verdict())
    assert lesson.check('10 %').startswith('Not yet. Measured: 31.6 %.')
    # what the node refuses is not right, however near it is
    assert lesson.check('31,7 %').startswith('Not yet. The node refuses it: it takes 31.6 % at most.')
    assert lesson.check('31,6 %').startswith('Right')


def hybrid(page, lesson):
    """Start both laws from the same place."""
    assert lesson.check() == 'Choose an answer.'
    assert 'Try both' in lesson.check('b')
    _go_from_the_start(page, lambda: page.keys('r'), 1.2)
    _go_from_the_start(page, lambda: lesson.move(0, 'h'), 1.2)
    answers = [lesson.check(letter) for letter in 'hb']
    assert sorted(answer.partition('.')[0] for answer in answers) == ['Not yet', 'Right'], answers
    assert 'Measured: backstepping ' in answers[0]


def fuzzy(page, lesson):
    """Wait until five seconds are measured."""
    colours = ('const canvas = document.querySelector("#lesson canvas"), place = canvas.getContext("2d");'
               'const all = place.getImageData(0, 0, canvas.width, canvas.height).data;'
               'return new Set(Array.from(all, (_, n) => n % 4 ? 0 : all[n] + 256 * all[n + 1])).size')
    page.wait(lambda: page.driver.execute_script(colours) > 10)
    _go_from_the_start(page, lambda: page.keys('r'), 5.2, lambda: lesson.check('9'), 'Let it drive for 5 s')
    wrong = lesson.check('9')
    assert wrong.startswith('Not yet. Measured: ')
    assert lesson.check(f'{100 * float(_measured(wrong)):.3g} cm').startswith('Right')


def windup(page, lesson):
    """Let the controller know no limit."""
    # the page hears what its lesson has set a moment later
    page.wait(lambda: 'First set velocity_controller.max_wheel_torque' in lesson.check('0.4'), look=lesson.verdict)
    _go_from_the_start(page, lambda: lesson.move(0, Keys.ARROW_DOWN), 10.1, factor=2.0)
    wrong = lesson.check('0,4 m')
    assert wrong.startswith('Not yet. Measured: 1.'), wrong
    assert lesson.check(_measured(wrong)).startswith('Right')


def path(page, lesson):
    """Look where the plan is limited."""
    page.wait(lambda: page.driver.execute_script(
        'const path = mrc.stage.path(); return path && Math.hypot(path.x[0], path.y[0]) < 1e-3'))
    # neither place is passed twice, so that both are seen, however late the page is asked
    _drive(page, 5.0)
    page.wait(lambda: page.number('y') > 0.95)
    run = page.number('run')
    page.keys('r')
    page.wait(lambda: page.number('run') > run and math.hypot(page.number('x'), page.number('y')) > 0.2)
    _drive(page, SLOW)
    page.wait(lambda: 'of the straights' in lesson.check(Keys.HOME), look=lesson.verdict)
    assert lesson.verdict().startswith('Not yet')
    assert lesson.check(Keys.END).startswith('Right')
    lesson.move(1, *[Keys.ARROW_LEFT] * 8)
    # so slow, it is the speed that limits the straights
    page.wait(lambda: lesson.check(Keys.HOME).startswith('Right'))


SOLUTIONS = {'1_errors': errors, '2_gains': gains, '3_hybrid': hybrid, '4_fuzzy': fuzzy, '5_windup': windup,
             '6_path': path}
