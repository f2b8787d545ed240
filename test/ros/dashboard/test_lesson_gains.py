"""The lesson of the gains."""

from helpers.lesson_solutions import SOLUTIONS, begin, draw_and_send


def test_the_lesson_is_passed_by_keyboard_on_a_phone_after_a_path_was_drawn_by_keyboard(page, live):
    draw_and_send(page)
    lesson = begin(page, '2_gains', 'phone')
    SOLUTIONS['2_gains'](page, lesson)
    lesson.close()
    # the path is given back, and its points on the page are gone
    assert live.asker.value('/reference_cart', 'curve') == 'path'
    page.wait(lambda: page.number('ref_linear') > 0.05)
    assert page.driver.execute_script('return document.querySelectorAll("#path button")[5].disabled')
