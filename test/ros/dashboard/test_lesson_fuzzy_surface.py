"""The lesson of the fuzzy surface."""

import re

from live_page import Lesson


def test_the_lesson_of_the_fuzzy_surface_draws_it_and_measures_the_distance(page, live):
    lesson = Lesson(page, 'The fuzzy surface')
    lesson.move(1, 'backstepping')
    page.wait(lambda: live.asker.value('/position_controller', 'controller_type') == 'backstepping')
    page.wait(lambda: 'Choose the fuzzy law' in lesson.check('0.04'))
    lesson.move(1, 'fuzzy')
    colours = ('const canvas = arguments[0].querySelector("canvas"), place = canvas.getContext("2d");'
               'const all = place.getImageData(0, 0, canvas.width, canvas.height).data;'
               'return new Set(Array.from(all, (_, n) => n % 4 ? 0 : all[n] + 256 * all[n + 1])).size')
    page.wait(lambda: page.driver.execute_script(colours, lesson.element) > 10)
    page.choose('speed', '0')
    run = page.number('run')
    page.find('#reset').click()
    page.wait(lambda: page.number('run') > run)
    page.wait(lambda: page.number('time') > 5.5 and lesson.check('9').startswith('In the last five'))
    measured = re.search(r'it was ([\d.]+) m', lesson.check('9'))[1]
    assert lesson.check(measured).startswith('Right')
