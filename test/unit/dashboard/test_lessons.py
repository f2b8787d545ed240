"""Lessons: faults of a file are told, changes of a lesson are taken back, and a run is known by what it had."""

import asyncio
import math
import re

import numpy as np
import pytest
import yaml

from mobile_robot_control import simulate
from mobile_robot_control.control.velocity_pi import VelocityGains, instability
from mobile_robot_control.dashboard import teaching as module
from mobile_robot_control.dashboard.lesson_files import read_lessons
from mobile_robot_control.dashboard.link import RunValues
from mobile_robot_control.dashboard.teaching import LessonError, RobotAccess, Teaching
from mobile_robot_control.parameters.declaration import ParameterError, flatten
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.law_sets import differing, shipped_set

GOOD = {
    'title': 'A lesson', 'text': 'Words.', 'question': 'How far?', 'robots': ['chapter'], 'show': ['e1'],
    'start': {'parameters': {'plant': {'max_wheel_torque': 0.3}}, 'pose': [0.0, -0.3, 0.0]},
    'controls': [{'label': 'gain', 'sets': ['position_controller.backstepping.p'], 'range': [1.0, 2.0, 0.1]}],
    'answer': {'kind': 'number', 'measure': 'mean', 'of': ['e1'], 'over': 5.0, 'unit': 'm', 'tolerance': 0.1},
}


def _changed(**changes):
    """Return the good lesson with other values by dotted name; None takes one out."""
    made = yaml.safe_load(yaml.safe_dump(GOOD))
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


class Nodes:
    """Stands for the nodes, whose parameters it keeps."""

    def __init__(self):
        self.values = {'plant': {'max_wheel_torque': 0.0, 'initial_pose': [1.0, 0.0, 0.0]},
                       'position_controller': {'backstepping.p': 1.5},
                       'reference_cart': {'curve': 'trifolium', 'center': [0.0, 0.0], 'rotation': 0.0, 'scale': 1.0,
                                          'period': 16.0, 'phase': 0.0}}
        self.poses, self.started, self.followed, self.resumed = [], {}, [], 0

    @property
    def access(self):
        return RobotAccess(self.present, self.initial, self.change, self.reset, self.follow, self.resume)

    async def initial(self):
        return {node: {name: value for name, value in values.items() if self.values[node][name] != value}
                for node, values in self.started.items()}

    async def follow(self, points, limits):
        self.followed.append(points)
        self.values['reference_cart'] |= {'curve': 'path', **limits}
        return await self.reset([*points[0], 0.0])

    async def resume(self):
        self.resumed += 1

    async def present(self):
        return {node: dict(values) for node, values in self.values.items()}

    async def change(self, node, values):
        self.values[node] |= values

    async def reset(self, pose):
        self.poses.append(pose)
        if pose is not None:
            self.values['plant']['initial_pose'] = pose
        return len(self.poses)


@pytest.fixture
def taught(tmp_path):
    """Return the nodes and a lesson of them."""
    (tmp_path / 'lesson.yaml').write_text(yaml.safe_dump(GOOD))
    nodes = Nodes()
    return nodes, Teaching(read_lessons(str(tmp_path)), 'chapter', nodes.access)


def test_what_a_lesson_changes_is_taken_back_by_its_own_page_alone(taught):
    nodes, teaching = taught
    before = asyncio.run(nodes.present())
    page = object()

    async def play():
        assert await teaching.begin('lesson', page) == 1
        assert nodes.values['plant']['max_wheel_torque'] == 0.3
        assert nodes.poses == [pytest.approx([1.3, 0.0, 1.5707963])]
        assert await teaching.move(0, 1.9) == 0
        assert nodes.values['position_controller']['backstepping.p'] == 1.9
        await teaching.end(object())
        assert teaching.running == 'lesson'
        await teaching.end(page)

    asyncio.run(play())
    assert teaching.running == ''
    assert nodes.values == before
    assert nodes.poses[-1] is None


def _started():
    """Return nodes with the default parameters of a run."""
    nodes = Nodes()
    nodes.values = {node: {name: list(value) if isinstance(value, tuple) else value
                           for name, value in flatten(part).items()} for node, part in configure({})._asdict().items()}
    nodes.started = asyncio.run(nodes.present())
    return nodes


@pytest.mark.parametrize('name', [lesson.name for lesson in read_lessons('')])
def test_a_lesson_sets_all_that_it_needs_after_a_drawn_path_and_changed_gains_and_gives_them_back(name):
    nodes = _started()
    nodes.values['reference_cart'] |= {'curve': 'path', 'period': 16.0, 'timing.max_wheel_torque': 0.2}
    nodes.values['position_controller'] |= {'controller_type': 'kanayama', 'backstepping.p': 3.0, 'fuzzy.a': 9.0}
    nodes.values['velocity_controller'] |= {'gains.k1': 0.3}
    before = asyncio.run(nodes.present())
    teaching = Teaching(read_lessons(''), 'chapter', nodes.access)
    law = teaching.lessons[name].parameters.get('position_controller', {}).get('controller_type', 'backstepping')

    async def play():
        await teaching.begin(name, None)
        assert nodes.values['reference_cart']['curve'] == ('path' if name == '6_path' else 'trifolium')
        gains = {node: given for node, given in differing(shipped_set(law), nodes.values).items()
                 if (name, node) != ('2_gains', 'velocity_controller')}
        assert gains == {}
        assert len(nodes.followed) == (name == '6_path')
        await teaching.end()

    asyncio.run(play())
    assert (nodes.values, nodes.resumed) == (before, 1)


def test_a_lesson_changes_to_a_law_with_its_shipped_set():
    nodes = _started()
    teaching = Teaching(read_lessons(''), 'chapter', nodes.access)

    async def play():
        await teaching.begin('4_fuzzy', None)
        assert differing(shipped_set('fuzzy'), nodes.values) == {}
        await teaching.move(1, 'backstepping')
        assert differing(shipped_set('backstepping'), nodes.values) == {}
        await teaching.end()

    asyncio.run(play())
    assert nodes.values == nodes.started


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


def test_a_lesson_waits_for_its_nodes(taught, monkeypatch):
    nodes, teaching = taught
    late = nodes.values.pop('position_controller')

    async def sleep(_):
        nodes.values['position_controller'] = late

    monkeypatch.setattr(asyncio, 'sleep', sleep)
    assert asyncio.run(teaching.begin('lesson', None)) == 1


def test_a_run_is_known_by_the_parameters_that_it_has_had():
    run, watched = RunValues(), {'position_controller': {'law'}, 'plant': {'paused'}}
    before = {'position_controller': {'law': 'a'}, 'plant': {'paused': False, 'initial_pose': [1.0]}, 'other': {}}
    changed = {**before, 'position_controller': {'law': 'b'}}
    # what is learned of a node, a pause and the next start change nothing of a run
    still = {**before, 'plant': {'paused': True, 'initial_pose': [2.0]}, 'other': {'x': 1.0}}
    for number, time, values, since, law, pose in (
            (1, 0.0, before, 0.0, 'a', [1.0]), (1, 1.0, still, 0.0, 'a', [1.0]), (1, 2.0, changed, 2.0, 'b', [1.0]),
            (1, math.nan, before, 2.0, 'a', [1.0]), (1, 3.0, before, 2.0, 'a', [1.0]),
            (2, 0.0, still, 0.0, 'a', [2.0])):
        run.note(number, time, values)
        paused = values['plant']['paused']
        assert run.shown(watched) == {
            'number': number, 'since': since, 'pose': pose, 'motion': {'position_controller.law': law},
            'values': {'plant.paused': paused, 'position_controller.law': law}}


def test_a_lesson_of_another_robot_or_without_its_node_changes_nothing(taught, tmp_path, monkeypatch):
    monkeypatch.setattr(module, '_PATIENCE', 0.0)
    nodes, teaching = taught
    before = asyncio.run(nodes.present())
    other = Teaching(tuple(teaching.lessons.values()), 'kobuki', nodes.access)
    del nodes.values['position_controller'], before['position_controller']
    for asked, words in (
            (other.begin('lesson', None), 'for chapter, and the robot here is kobuki; start dashboard --robot chapter'),
            (teaching.begin('lessen', None), 'no such lesson'), (teaching.move(0, 1.0), 'has ended'),
            (teaching.begin('lesson', None), 'position_controller, which is not there')):
        with pytest.raises(LessonError, match=words):
            asyncio.run(asked)
    assert nodes.values == before
