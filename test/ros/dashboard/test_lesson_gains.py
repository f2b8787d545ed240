"""The lesson of the gains of the velocity controller."""

from live_page import Lesson


def test_the_lesson_of_the_gains_shows_the_words_of_the_node(page, live):
    lesson = Lesson(page, '1577 Hz')
    before = live.asker.value('/velocity_controller', 'gains.k1')
    lesson.move(0, '1')
    page.wait(lambda: '157' in lesson.verdict())
    assert live.asker.value('/velocity_controller', 'gains.k1') == before
    assert not lesson.check('90').startswith('Right')
    assert lesson.check('32').startswith('Right')
