"""The last path of the page in a new run: sent again where the cart awaits one, and the drawn one after a lesson."""

import asyncio
from collections import Counter
from concurrent.futures import Future
from types import SimpleNamespace

import pytest

from mobile_robot_control.dashboard.path_driving import PathDriver
from mobile_robot_control.dashboard.publishing import SketchPoint
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.settings.configure import configure

DRAWN = [SketchPoint(0.0, 0.0), SketchPoint(1.0, 0.0)]
OF_A_LESSON = [[0.0, 0.0], [0.0, 2.0]]
LIMITS = {'timing.max_linear_velocity': 1.0, 'timing.max_wheel_torque': 0.3}


class Robot:
    """Stands for the robot, whose cart takes each path."""

    def __init__(self, **cart):
        whole = configure({'reference_cart': LIMITS})
        self.values = {'reference_cart': flatten(whole.reference_cart) | {'center': [0.0, 0.0], **cart},
                       'plant': flatten(whole.plant)}
        self.done, counts = [], Counter()

        def send(points, _):
            self.done.append([tuple(point[:2]) for point in points])
            counts['reference_cart', 'path'] += 1

        link = SimpleNamespace(paths=SimpleNamespace(send=send), events=SimpleNamespace(counts=counts),
                               book=SimpleNamespace(nodes={}), submit=self.submit)
        self.driver = PathDriver(link, self.present, self.change, self.begin_run)
        self._counts = counts

    @staticmethod
    def submit(job):
        done = Future()
        done.set_result(job())
        return done

    async def present(self):
        return self.values

    async def change(self, node, values):
        self.values[node] |= values

    async def begin_run(self, pose):
        self._counts['reference_cart', 'curve'] += 1
        self.done.append(pose)
        return len(self.done)


def test_a_new_run_drives_the_path_of_the_lesson_again_and_after_it_the_drawn_one():
    robot = Robot()
    driver = robot.driver

    async def play():
        assert await driver.run_again(None) is None
        assert (await driver.path(DRAWN, LIMITS)).good
        await driver.follow(OF_A_LESSON, LIMITS)
        robot.done.clear()
        for pose in (None, [1.0, 0.0, 0.0]):
            assert (await driver.run_again(pose)).good
        await driver.resume()
        assert (await driver.run_again(None)).good

    asyncio.run(play())
    drawn, taught = ([tuple(point[:2]) for point in points] for points in (DRAWN, OF_A_LESSON))
    assert robot.done == [None, taught, [1.0, 0.0, 0.0], taught, drawn, None, drawn]


@pytest.mark.parametrize(('node', 'values'), [
    ('reference_cart', {'curve': 'trifolium'}), ('reference_cart', {'path.file': 'path.csv'}),
    ('plant', {'lockstep': False}),
])
def test_a_cart_with_a_course_of_its_own_gets_no_path_again(node, values):
    robot = Robot(curve='path')

    async def play():
        assert (await robot.driver.path(DRAWN, LIMITS)).good
        robot.values[node] |= values
        robot.done.clear()
        assert await robot.driver.run_again(None) is None

    asyncio.run(play())
    assert robot.done == []
