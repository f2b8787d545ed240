"""The link of the live page to the robot: its jobs, and the parameters that a run has had."""

import math
import types

import pytest

from mobile_robot_control.dashboard.link import RobotLink, RunValues


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


@pytest.fixture
def link():
    made = RobotLink('/')
    made.calls = made.disturbances = types.SimpleNamespace(look=lambda: None)
    return made


def test_the_link_goes_on_after_the_jobs_that_wait(link):
    done = []
    link.calls.look = lambda: done.append('looked')

    def again():
        done.append('job')
        link.submit(again)

    link.submit(again)
    link._do_jobs()
    assert done == ['job', 'looked', 'looked']


def test_the_link_passes_over_the_jobs_of_a_page_that_has_gone(link):
    done = []
    assert link.submit(lambda: done.append('job')).cancel()
    answered = link.submit(lambda: 'answer')
    link._do_jobs()
    assert answered.result(0.0) == 'answer'
    assert done == []
