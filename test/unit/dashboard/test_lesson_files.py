"""Files of lessons: faults are told, and the numbers in them are those of the commands."""

import math
import re

import numpy as np
import pytest
import yaml
from helpers.small_lesson import LESSON

from mobile_robot_control import simulate
from mobile_robot_control.control.velocity_pi import VelocityGains, instability
from mobile_robot_control.dashboard.lesson_files import read_lessons
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.law_sets import shipped_set


def _changed(**changes):
    """Return the good lesson with other values by dotted name; None takes one out."""
    made = yaml.safe_load(yaml.safe_dump(LESSON))
    for name, value in changes.items():
        *path, last = name.split('__')
        part = made
        for key in path:
            part = part[int(key) if key.isdigit() else key]
        if value is None:
            del part[last]
        else:
            part[last] = value
    return made


def _refusal(folder, text=''):
    """Return why the lesson of a folder is refused."""
    (folder / 'lesson.yaml').write_text(text, errors='surrogatepass')
    with pytest.raises(ParameterError) as refused:
        read_lessons(str(folder))
    assert str(folder / 'lesson.yaml') in str(refused.value)
    return str(refused.value)


@pytest.mark.parametrize(('lesson', 'words'), [
    ([], 'is no lesson'),
    (_changed(title=None), 'title is missing'),
    (_changed(titel='A'), "titel is not known; did you mean 'title'"),
    (_changed(robots='chapter'), 'robots = chapter must be a list'),
    (_changed(show=['e4']), 'must be a list of columns'),
    (_changed(chart='forces'), 'must be one of errors'),
    (_changed(start__pose=[0, 0]), 'start.pose'),
    (_changed(start__parameters={'plent': {'paused': True}}), 'names no node'),
    (_changed(start__parameters={'plant': {'pausd': True}}), "no parameter 'pausd'; did you mean 'paused'"),
    (_changed(controls=[]), 'controls = [] must be'),
    (_changed(controls__0__choices=['a', 'b']), 'either range or choices'),
    (_changed(controls__0__sets=['pose.up']), 'no part of the start'),
    (_changed(controls__0__sets=['plan.timing.max_wheel_torque']), 'of a lesson with a plan'),
    (_changed(controls__0__times=[1, 2]), 'a number for each of sets'),
    (_changed(answer__kind='guess'), 'must be one of place, number, larger, plan'),
    (_changed(answer__measure='most'), 'must be one of now, mean'),
    (_changed(answer__of=None), 'nothing is measured'),
    (_changed(answer__tolerance=None), 'a tolerance, or a share'),
    (_changed(answer={'kind': 'plan', 'limit': 'x', 'choices': ['a', 'b', 'c']}), 'needs the points of a plan'),
    (_changed(answer__with={'plant.x': 1}), "no parameter 'x'"),
])
def test_a_lesson_at_fault_is_told_with_its_file(tmp_path, lesson, words):
    assert words in _refusal(tmp_path, yaml.safe_dump(lesson))


def test_a_folder_without_lessons_and_a_file_that_is_no_yaml_are_told(tmp_path):
    with pytest.raises(ParameterError, match='there is no lesson in this folder'):
        read_lessons(str(tmp_path))
    for text in ('a: [', '2001-99-99', '- ' * 5000, 'a: \x00', '\ud8ff'):
        _refusal(tmp_path, text)


def test_numbers_in_lessons_are_those_of_the_command():
    lessons = {lesson.name: lesson for lesson in read_lessons('')}

    def driven(name, duration, law, **changes):
        """Return the largest distance, and largest torque and its time, of a run from a lesson's start."""
        start = reference_at(CURVES['trifolium'], 0.0, Placement()).pose
        ahead, left, turn = lessons[name].pose
        assert (ahead, turn, start.heading) == (0.0, 0.0, pytest.approx(0.5 * math.pi))
        given = {f'{node}.{key}': value for node, values in lessons[name].parameters.items()
                 for key, value in values.items() if key == 'max_wheel_torque'}
        run = simulate(shipped_set(law).file, duration=duration, parameters=given | changes | {
            'plant.initial_pose': [start.x - left, start.y, start.heading]})
        torque = abs(run.wheel_torque).max(axis=1)
        return (np.hypot(*run.tracking_error.T[:2]).max(), torque.max(), run.time[torque.argmax()])

    right = {name: lesson.content['answer'].get('right', '') for name, lesson in lessons.items()}
    _, torque, at = driven('3_hybrid', 4.0, 'hybrid_backstepping')
    _, first, _ = driven('3_hybrid', 1.0, 'backstepping')
    assert (f'that is {torque:.3g} N m after {at:.1f} s, where backstepping begins with {first:.3g} N m'
            in right['3_hybrid'])
    assert f'it is {driven("5_windup", 10.0, "backstepping")[0]:.3g} m' in right['5_windup']
    gains = lessons['2_gains'].parameters['velocity_controller']

    def instability_of(share):
        robot = configure({}).plant.shared.robot
        return instability(VelocityGains(*(gains[f'gains.{name}'] * (share / 2.0 if name[0] == 'k' else 1.0)
                                           for name in VelocityGains._fields)), robot, 500.0, True)

    assert f'{float(re.search(r"rate is ([0-9.]+) Hz", instability_of(100.0))[1]):.0f} Hz' in right['2_gains']
    assert not instability_of(31.6)
    assert instability_of(31.7)
    assert '31.7 %' in right['2_gains']
