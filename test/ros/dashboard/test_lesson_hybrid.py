"""The lesson of the hybrid law."""

from helpers.lesson_solutions import SOLUTIONS, begin


def test_the_lesson_is_passed_by_keyboard_on_a_desktop(page):
    lesson = begin(page, '3_hybrid', 'desktop')
    SOLUTIONS['3_hybrid'](page, lesson)
    lesson.close()
