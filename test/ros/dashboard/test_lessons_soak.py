"""Each lesson on each robot that it names: in any order, twice, at alternating sizes."""

import random

import pytest
from lesson_solutions import SIZES, SOLUTIONS, begin
from live_page import LivePage, OpenPage

from mobile_robot_control.dashboard.lesson_files import read_lessons

LESSONS = read_lessons('')


@pytest.mark.soak
@pytest.mark.timeout(600)
@pytest.mark.parametrize('robot', sorted({robot for lesson in LESSONS for robot in lesson.robots}))
def test_every_lesson_of_a_robot_is_passed_in_any_order(domain, browser, tmp_path, robot):
    order = [lesson.name for lesson in LESSONS if robot in lesson.robots] * 2
    random.Random(robot).shuffle(order)  # noqa: S311 (an order)
    live = LivePage(tmp_path, '--robot', robot)
    try:
        browser.call('Emulation.setDeviceMetricsOverride', width=1280, height=800, deviceScaleFactor=1, mobile=False)
        page = OpenPage(browser, live.address, 4 if robot in LESSONS[1].robots else None)
        for n, name in enumerate(order):
            lesson = begin(page, name, list(SIZES)[n % 2])
            SOLUTIONS[name](page, lesson)
            lesson.close()
            print(robot, name, 'passed')
    finally:
        browser.driver.get('about:blank')
        live.close()
