"""The lesson of windup, which starts a plant of its own, and takes back what it changed."""

from lesson_solutions import SOLUTIONS, begin

_CHANGED = {'/plant': ('max_wheel_torque', 'initial_pose', 'real_time_factor', 'paused'),
            '/velocity_controller': ('max_wheel_torque',)}


def test_the_lesson_of_windup_is_passed_by_keyboard_and_leaves_nothing_behind(page, live):
    def values():
        return {(node, name): live.asker.value(node, name) for node, names in _CHANGED.items() for name in names}

    before = values()
    lesson = begin(page, '5_windup', 'desktop')
    assert live.asker.value('/plant', 'max_wheel_torque') == 0.3
    SOLUTIONS['5_windup'](page, lesson)
    lesson.close()
    assert values() == before
