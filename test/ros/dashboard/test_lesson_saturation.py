"""The lesson of saturation."""

import re

from live_page import Lesson


def test_the_lesson_of_saturation_measures_a_lap_without_limit(page, live):
    lesson = Lesson(page, 'Saturation')
    lesson.move(0, '0.2')
    page.wait(lambda: 'Take the limit away' in lesson.check('1'))
    lesson.move(0, '0')
    lesson.move(1, '8')
    page.wait(lambda: live.asker.value('/reference_cart', 'period') == 8.0)
    run = page.number('run')
    page.find('#reset').click()
    page.wait(lambda: page.number('run') > run)
    page.wait(lambda: 'Let it drive a lap' in lesson.check('1'))
    page.choose('speed', '0')
    page.wait(lambda: lesson.check('99').startswith('In the last lap'))
    # so fast a run is seen four times a second: each lap shows other peaks
    page.keys(' ')
    page.wait(lambda: 'paused' in page.text('nodes'))
    measured = re.search(r'at most ([\d.]+) N m', lesson.check('99'))[1]
    assert lesson.check(measured).startswith('Right')
