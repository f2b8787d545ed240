"""Lessons: what they need is set, and what they change is taken back."""

import asyncio

import pytest
import yaml
from helpers.small_lesson import LESSON

from mobile_robot_control.dashboard import teaching as module
from mobile_robot_control.dashboard.lesson_files import read_lessons
from mobile_robot_control.dashboard.teaching import LessonError, RobotAccess, Teaching
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.law_sets import differing, shipped_set


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
    (tmp_path / 'lesson.yaml').write_text(yaml.safe_dump(LESSON))
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


def test_a_lesson_waits_for_its_nodes(taught, monkeypatch):
    nodes, teaching = taught
    late = nodes.values.pop('position_controller')

    async def sleep(_):
        nodes.values['position_controller'] = late

    monkeypatch.setattr(asyncio, 'sleep', sleep)
    assert asyncio.run(teaching.begin('lesson', None)) == 1


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
