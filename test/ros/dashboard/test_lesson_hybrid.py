"""The lesson of the hybrid law."""

from live_page import Lesson


def _driven(page, run, seconds):
    """Wait until a later run than one has lasted some simulated seconds; return its number."""
    page.wait(lambda: page.number('run') > run and page.number('time') > seconds)
    return page.number('run')


def test_the_lesson_of_the_hybrid_law_compares_measured_torques(page):
    lesson = Lesson(page, 'started beside the path')
    page.choose('speed', '1')
    assert 'Start both' in lesson.check('backstepping')
    run = page.number('run')
    lesson.move(1, '0.4')
    run = _driven(page, run, 1.2)
    lesson.move(0, 'hybrid_backstepping')
    _driven(page, run, 1.2)
    assert lesson.check('backstepping').startswith('Right. Backstepping asked for ')
    assert not lesson.check('hybrid_backstepping').startswith('Right')
