"""Models in the words of other stacks."""

import numpy as np
import pytest
import yaml

from mobile_robot_control.identification.export import export_text
from mobile_robot_control.identification.result import Identification, Judgement, Parameter

SMOOTHER = {'smoothing_frequency', 'feedback', 'scale_velocities', 'max_velocity', 'min_velocity', 'max_accel',
            'max_decel', 'odom_topic', 'odom_duration', 'deadband_velocity', 'velocity_timeout',
            'use_realtime_priority'}
MPPI_DELAYS = {'model_delay_vx', 'model_delay_vy', 'model_delay_wz'}
DIFF_DRIVE = {'wheel_separation_multiplier', 'left_wheel_radius_multiplier', 'right_wheel_radius_multiplier', *(
    f'{axis}.{name}' for axis in ('linear.x', 'angular.z')
    for name in ('max_velocity', 'max_acceleration', 'max_deceleration'))}


def result_of(**values):
    parameters = tuple(Parameter(f'plant.{name}', value, 0.9 * value, 1.1 * value, 's')
                       for name, value in values.items())
    return Identification('velocity', parameters, (), np.zeros((0, 0)), (), {}, {}, (), (), (), (), np.zeros((0, 2)),
                          {'command_line': 'identify bag'}, Judgement('good', (0.01, 0.02), {}))


def test_what_other_stacks_take_has_their_names_and_what_is_not_known_is_left_open():
    both = {f'base.{name}[{n}]': 0.1 + n for name in ('lag', 'dead_time', 'max_speed', 'max_acceleration', 'dead_zone')
            for n in (0, 1)}
    errors = {'odometry.radius_error[0]': 0.25, 'odometry.radius_error[1]': 0.0, 'odometry.separation_error': -0.2}
    nav2 = yaml.safe_load(export_text(result_of(**both), 'nav2'))
    smoother = nav2['velocity_smoother']['ros__parameters']
    assert set(smoother) <= SMOOTHER
    assert smoother['max_velocity'] == [0.1, 0.0, 1.1]
    assert smoother['max_decel'] == [-0.1, 0.0, -1.1]
    delays = nav2['controller_server']['ros__parameters']['FollowPath']
    assert set(delays) <= MPPI_DELAYS
    assert delays == {'model_delay_vx': pytest.approx(0.2), 'model_delay_wz': pytest.approx(2.2)}
    drive = yaml.safe_load(export_text(result_of(**both, **errors), 'ros2_control'))['diff_drive_controller']
    assert set(drive['ros__parameters']) == DIFF_DRIVE
    assert drive['ros__parameters']['right_wheel_radius_multiplier'] == pytest.approx(0.8)
    assert drive['ros__parameters']['wheel_separation_multiplier'] == pytest.approx(1.25)
    # a limit that does not show is never a limit of 0
    text = export_text(result_of(**{'base.max_speed[0]': 0.5, 'base.dead_zone[0]': 0.05}), 'nav2')
    assert '# max_velocity: [0.5, 0.0, ?]' in text
    assert yaml.safe_load(text)['velocity_smoother']['ros__parameters'] == {'deadband_velocity': [0.05, 0.0, 0.0]}
    assert 'ground_truth' in export_text(result_of(), 'ros2_control')
