"""The lesson of the torque limit along a path."""

from live_page import Lesson


def test_the_lesson_of_the_torque_limit_plans_the_path_and_tells_where_it_acts(page):
    lesson = Lesson(page, 'Where a torque limit')
    assert 'of the straights' in lesson.check('in the bends alone')
    assert not lesson.verdict().startswith('Right')
    assert lesson.check('in the bends and on the straights').startswith('Right')
    lesson.move(1, '0.2')
    page.wait(lambda: lesson.verdict() == '')
    # so slow, it is the speed that limits the straights
    assert lesson.check('in the bends alone').startswith('Right')
