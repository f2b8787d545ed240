"""The lesson of windup, which starts a plant of its own, and takes back what it changed."""

import pytest
from helpers.lesson_solutions import SOLUTIONS, begin

_CHANGED = {'/plant': ('max_wheel_torque', 'initial_pose', 'real_time_factor', 'paused'),
            '/velocity_controller': ('max_wheel_torque',)}


@pytest.mark.soak
def test_the_lesson_of_windup_is_passed_by_keyboard_and_leaves_nothing_behind(page, live):
    def values():
        return {(node, name): live.asker.value(node, name) for node, names in _CHANGED.items() for name in names}

    before = values()
    lesson = begin(page, '5_windup', 'desktop')
    assert live.asker.value('/plant', 'max_wheel_torque') == 0.3
    SOLUTIONS['5_windup'](page, lesson)
    # two minutes later, the span that is asked about is still known
    page.driver.execute_script(
        'const time = mrc.live.columns.indexOf("time"), newest = mrc.stage.newest();'
        'const late = (n) => newest.map((value, at) => at === time ? 12 + n / 20 : value);'
        'mrc.live.tell("rows", Array.from({length: 2500}, (_, n) => late(n)))')
    assert lesson.check('0,4 m').startswith('Not yet. Measured: 1.')
    lesson.close()
    assert values() == before
