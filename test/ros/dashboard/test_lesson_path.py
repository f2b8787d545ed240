"""The lesson of the torque limit along a path."""

import pytest
from helpers.lesson_solutions import SOLUTIONS, begin


@pytest.mark.soak
def test_the_lesson_is_passed_by_keyboard_on_a_phone(page, live):
    lesson = begin(page, '6_path', 'phone')
    SOLUTIONS['6_path'](page, lesson)
    lesson.close()
    assert live.asker.value('/reference_cart', 'curve') == 'trifolium'
