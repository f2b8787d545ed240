"""The lesson of the errors e1, e2 and e3."""

from live_page import Lesson


def test_the_lesson_of_the_errors_is_checked_by_measuring(page):
    lesson = Lesson(page, 'e1, e2 and e3')
    lesson.move(0, '-0.2')
    page.wait(lambda: abs(page.number('e1') - 0.2) < 0.01)
    lesson.move(1, '-0.1')
    page.wait(lambda: abs(page.number('e2') - 0.1) < 0.01)
    assert lesson.check().startswith('It is e1 = 0.2')
    lesson.move(1, '0.1')
    page.wait(lambda: abs(page.number('e2') + 0.1) < 0.01)
    assert lesson.check().startswith('Right')
