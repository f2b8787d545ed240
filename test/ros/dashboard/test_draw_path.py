"""A path that is drawn on the page, by pointer and by keyboard, is planned, sent and followed."""

import re

from selenium.webdriver import ActionChains
from selenium.webdriver.common.keys import Keys


def _words(page):
    return page.text('path-words')


def test_a_drawn_path_is_followed_as_it_was_planned_and_the_next_one_joins_it(page, live):
    # so slow that the cart is still near the start when the path is sent again
    page.choose('speed', '0.1')
    run = page.number('run')
    bar = page.find('#path')
    buttons = {button.text: button for button in bar.find_elements('css selector', 'button')}
    scene = page.find('#scene')
    page.driver.execute_script('arguments[0].scrollIntoView()', scene)
    buttons['Draw'].click()
    page.wait(lambda: page.driver.execute_script('return document.activeElement.id') == 'scene')
    keys = ActionChains(page.driver)
    for key in (Keys.ENTER, *(Keys.ARROW_LEFT,) * 8, Keys.ENTER, *(Keys.ARROW_UP,) * 6, Keys.ENTER):
        keys.send_keys(key)
    keys.perform()
    # 0.8 m and 0.6 m with a rounded corner: two points alone have a plan, too
    page.wait(lambda: _words(page).startswith('1.3'))
    before = _words(page)
    words = page.driver.execute_async_script(
        'const words = [], pen = CanvasRenderingContext2D.prototype, {fillText} = pen;'
        'pen.fillText = function (...given) { words.push(given[0]); fillText.apply(this, given); };'
        'mrc.stage.redraw(); requestAnimationFrame(() => requestAnimationFrame(() => {'
        'pen.fillText = fillText; arguments[0](words); }))')
    fastest = re.search(r'at most (\S+ m/s)', before)[1]
    assert {'robot', 'L', 'R', 'error  0', 'speed  0', fastest, '1', '2', '3'} <= set(words)
    # the cross stays in view, however far it goes
    scene.send_keys(*[Keys.SHIFT, *[Keys.ARROW_RIGHT] * 12])
    x, y = map(float, re.fullmatch(r'cross at (.*), (.*) m', _words(page)).groups())
    page.wait(lambda: page.driver.execute_script(
        'const [px, py] = mrc.stage.toScreen(arguments[0], arguments[1]), {clientWidth, clientHeight} = arguments[2];'
        'return 0 < px && px < clientWidth && 0 < py && py < clientHeight', x, y, scene))
    scene.send_keys(*[Keys.SHIFT, *[Keys.ARROW_LEFT] * 12])
    # a point by the pointer, beside the others, taken back
    ActionChains(page.driver).move_to_element_with_offset(scene, -60, 30).click().perform()
    page.wait(lambda: 'Active limits' in _words(page) and _words(page) != before)
    buttons['Undo'].click()
    page.wait(lambda: _words(page) == before)
    buttons['Send'].click()
    page.wait(lambda: _words(page) == 'The cart follows it.')
    assert live.asker.value('/reference_cart', 'curve') == 'path'
    page.wait(lambda: page.number('run') > run and page.number('ref_linear') > 0.1)
    # the same path again begins behind the cart, and joins it in the same run
    run = page.number('run')
    buttons['Send'].click()
    page.settle()
    page.wait(lambda: _words(page) == 'The cart follows it.')
    assert page.number('run') == run
    page.choose('speed', '1')
    page.wait(lambda: 'arrived' in page.text('nodes'))
    page.choose('speed', '0.1')
    # from its end on the spot to the right, and backwards; the pointer takes the last point back
    buttons['Clear'].click()
    scene.send_keys(Keys.ENTER, *[Keys.ARROW_RIGHT] * 5, Keys.ENTER, 't', *[Keys.ARROW_DOWN] * 5, Keys.ENTER, 'b',
                    *[Keys.ARROW_UP] * 3, Keys.ENTER)
    page.wait(lambda: 'dashed backwards' in _words(page))
    assert buttons['Backwards'].get_attribute('aria-pressed') == 'true'
    # a turn is over before a busy machine has asked the page twice
    page.driver.execute_script(
        'window.phases = []; const [v, omega] = ["ref_linear", "ref_angular"].map((name) => mrc.live.column(name));'
        'mrc.live.on("rows", (rows) => rows.forEach((row) => {'
        'const phase = v(row) > 0.1 ? "ahead" : v(row) < -0.1 ? "back"'
        ': v(row) === 0 && Math.abs(omega(row)) > 0.1 ? "turn" : "";'
        'if (phase && phase !== window.phases[window.phases.length - 1]) window.phases.push(phase); }))')
    page.choose('speed', '1')
    buttons['Send'].click()
    page.wait(lambda: _words(page) == 'The cart follows it.')
    assert live.asker.value('/reference_cart', 'path.turn_back') == 'reverse'
    page.wait(lambda: page.driver.execute_script('return window.phases.includes("back")'),
              look=lambda: page.driver.execute_script('return window.phases'))
    assert page.driver.execute_script('return window.phases.slice(0, 2)') == ['ahead', 'turn']
