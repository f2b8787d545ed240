"""The page open for long: memory stays flat in nodes, page process and browser tab; each lesson on each robot."""

import os
import random
import statistics
import time

import pytest
from helpers.lesson_solutions import SIZES, SOLUTIONS, begin
from helpers.live_page import LivePage, OpenPage, megabytes

from mobile_robot_control.dashboard.lesson_files import read_lessons

LESSONS = read_lessons('')
SOAK = float(os.environ.get('SOAK_SECONDS', '3600'))
WARM = min(120.0, 0.25 * SOAK)
LARGEST = 1.1
"""Of the memory at the end to that when all was warm."""
MORE = 8.0
"""[MB] that any of them may have more."""


def _of_tab(page):
    """Return the memory of the page's scripts after a collection [MB]."""
    page.browser.call('HeapProfiler.collectGarbage')
    return page.browser.call('Runtime.getHeapUsage')['usedSize'] / 1e6


@pytest.mark.soak
@pytest.mark.timeout(SOAK + 300)
def test_an_open_page_does_not_grow(domain, browser, tmp_path):
    live = LivePage(tmp_path)
    try:
        page = OpenPage(browser, live.address)
        pids = {f'node {pid}': pid for pid in live.nodes()} | {'page': live.process.pid}
        begun, found = time.monotonic(), {name: [] for name in [*pids, 'tab']}
        while time.monotonic() < begun + SOAK:
            time.sleep(min(10.0, SOAK / 40))
            if time.monotonic() > begun + WARM:
                for name, pid in pids.items():
                    found[name].append(megabytes(pid))
                found['tab'].append(_of_tab(page))
                # what the driver keeps of each request and line
                assert not browser.errors()
                browser.requests()
        for name, course in found.items():
            fifth = max(1, len(course) // 5)
            early, late = statistics.median(course[:fifth]), statistics.median(course[-fifth:])
            print(f'{name}: {early:.1f} MB, then {late:.1f} MB')
            assert late < max(LARGEST * early, early + MORE), name
        reached = page.number('time')
        page.wait(lambda: page.number('time') > reached)
    finally:
        browser.driver.get('about:blank')
        live.close()


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
