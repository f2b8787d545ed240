"""The lesson of the fuzzy surface."""

from helpers.lesson_solutions import SOLUTIONS, begin, draw_and_send


def test_the_lesson_is_passed_by_keyboard_on_a_phone_after_a_path_was_drawn_by_pointer(page, live):
    draw_and_send(page, by_pointer=True)
    lesson = begin(page, '4_fuzzy', 'phone')
    assert live.asker.value('/position_controller', 'fuzzy.a') == 0.0523369
    assert live.asker.value('/velocity_controller', 'gains.k1') == 0.498752
    assert 'fuzzy, shipped gains' in page.text('run')
    SOLUTIONS['4_fuzzy'](page, lesson)
    lesson.close()
    assert live.asker.value('/velocity_controller', 'gains.k1') == 0.168617
