"""The lesson of the gains."""

from helpers.lesson_solutions import SOLUTIONS, begin


def test_the_lesson_is_passed_by_keyboard_on_a_phone(page):
    lesson = begin(page, '2_gains', 'phone')
    SOLUTIONS['2_gains'](page, lesson)
    lesson.close()
