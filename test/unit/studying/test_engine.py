"""Robots drawn from the covariance of an identification."""

import numpy as np
import pytest

import mobile_robot_control as mrc
from mobile_robot_control.loop.scenarios import with_robot
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.studying.request import draw_robots

NAMES = ('plant.base.lag[0]', 'plant.base.lag[1]', '/**.robot.wheel_separation')
VALUES, COVARIANCE = (0.1, 0.2, 0.35), ((1e-4, 5e-5, 0.0), (5e-5, 4e-4, 0.0), (0.0, 0.0, 1e-6))


def written(path, names=NAMES, values=VALUES, covariance=COVARIANCE):
    numbers = ', '.join(repr(float(value)) for row in covariance for value in row)
    path.write_text(
        '/**:\n  ros__parameters: {lockstep: true}\n'
        '/**/plant:\n  ros__parameters: {drive: velocity, base.lag: [0.1, 0.2]}\n'
        f'/**/identify:\n  ros__parameters:\n    names: {list(names)}\n    values: {list(values)}\n'
        f'    covariance: [{numbers}]\n')
    return str(path)


def drawn_robots(file, count, seed):
    return list(draw_robots(file, ParameterSources(file).configuration(), count, seed))


def test_robots_have_the_covariance_and_the_first_ones_are_the_same(tmp_path):
    file = written(tmp_path / 'found.yaml')
    robots = drawn_robots(file, 4000, 7)
    assert robots[:5] == drawn_robots(file, 5, 7)
    drawn = np.array([[value for _, value in robot] for robot in robots])
    assert drawn.mean(axis=0) == pytest.approx(VALUES, rel=0.01)
    assert np.cov(drawn.T) == pytest.approx(np.array(COVARIANCE), rel=0.1, abs=3e-6)
    plant = with_robot(ParameterSources(file).configuration(), robots[0]).plant
    assert (*plant.model.base.lag, plant.shared.robot.wheel_separation) == tuple(drawn[0].tolist())


def test_a_robot_out_of_its_bounds_is_drawn_again(tmp_path):
    file = written(tmp_path / 'found.yaml', NAMES[:1], (0.1,), ((0.04,),))
    assert min(value for (_, value), in drawn_robots(file, 200, 1)) >= 0.0


@pytest.mark.parametrize(('change', 'told'), [
    ({'names': ('plant.base.speed[0]', *NAMES[1:])}, 'the plant has no parameter'),
    ({'values': VALUES[:2]}, 'do not belong together'),
    ({'covariance': COVARIANCE[:2]}, 'has no section /**/identify'),
    ({'covariance': ((-1.0, 0.0, 0.0), *COVARIANCE[1:])}, 'do not belong together'),
    ({'values': (-5.0, 0.2, 0.35)}, 'must be at least 0.0'),
])
def test_a_file_that_does_not_fit_is_refused(change, told, tmp_path):
    file = written(tmp_path / 'found.yaml', **change)
    with pytest.raises(ParameterError, match=told.replace('*', r'\*')):
        drawn_robots(file, 1, 1)


def test_a_study_draws_robots_and_keeps_all_else(plain, tmp_path):
    file = written(tmp_path / 'found.yaml')
    options = {'runs': 2, 'seed': 3, 'laps': 0.02, 'workers': 1}
    plain = mrc.study(file, variation=0.0, **options).runs
    varied = mrc.study(robot_uncertainty=file, **options).runs
    assert 'plant.base.lag[0]' not in plain
    for name in ('curve', 'scale', 'start_x', 'start_yaw', 'mass_factor', 'noise_seed', 'delay'):
        assert varied[name].tolist() == plain[name].tolist()
    assert varied['plant.base.lag[1]'].tolist() == [dict(robot)['plant.base.lag[1]']
                                                    for robot in drawn_robots(file, 2, 3)]
    assert (varied['rms_position_error'] != plain['rms_position_error']).all()
