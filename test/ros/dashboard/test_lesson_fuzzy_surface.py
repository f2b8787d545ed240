"""The lesson of the fuzzy surface."""

from helpers.lesson_solutions import SOLUTIONS, begin


def test_the_lesson_is_passed_by_keyboard_on_a_phone(page):
    lesson = begin(page, '4_fuzzy', 'phone')
    SOLUTIONS['4_fuzzy'](page, lesson)
    lesson.close()
