"""A run of the live page is known by the parameters that it has had."""

import math

from mobile_robot_control.dashboard.link import RunValues


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
