"""The lesson of e1, e2 and e3."""

from helpers.lesson_solutions import SOLUTIONS, begin


def test_the_lesson_is_passed_by_keyboard_on_a_desktop(page):
    lesson = begin(page, '1_errors', 'desktop')
    SOLUTIONS['1_errors'](page, lesson)
    lesson.close()
