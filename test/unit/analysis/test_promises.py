"""What the numbers of a search or study hold for, in words: what was modelled, margins, and warnings."""

import json
import math

import pytest

from mobile_robot_control.analysis.margins import UNKNOWN, UNSTABLE, LapMargins, LoopMargins, Margins
from mobile_robot_control.analysis.modelled import EFFECTS, describe_model, drive_of, pattern_of, smooth_part
from mobile_robot_control.analysis.promises import (
    Promise,
    brief_lines,
    describe_scenarios,
    promise_lines,
    promise_values,
    warnings_of,
)
from mobile_robot_control.loop.scenarios import configured_scenario, rubbed
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.nodes import Configuration

IDEAL = Configuration()
ROUGH = configure({
    'plant': {'delay.velocity_steps': 2, 'noise.pose': [0.01, 0.01, 0.02], 'noise.velocity': 0.1,
              'max_wheel_torque': 3.0, 'disturbance.step': [0.1, 0.0]},
    'velocity_controller': {'max_wheel_torque': 2.5},
    'position_controller': {'limits.linear_velocity': 0.5, 'limits.angular_acceleration': 3.0},
})


def promised(gain=5.0, lowest=0.0, delay=10.0, lockstep=True, configuration=IDEAL, reason=''):
    """Return a promise at 500 and 100 Hz whose loops have the same margins."""
    both = LapMargins(Margins(gain, lowest, delay), 1.0, 2.0)
    return Promise(describe_model(configuration), LoopMargins(both, both, reason), 0.002, 0.01, lockstep)


def test_what_is_modelled_has_its_value_and_unit():
    found = describe_model(ROUGH)
    assert found.modelled == {
        'dead time of the motors': '2 velocity periods',
        'limit of the torque': '3 N m, 2.5 N m',
        'limit of the speed': '0.5 m/s',
        'limit of the acceleration': '3 rad/s²',
        'noise': '0.01 m and 0.01 m and 0.02 rad, 0.1 rad/s',
        'disturbance': '0.1 and 0 N m',
    }
    assert not describe_model(IDEAL).modelled


def test_every_effect_is_either_modelled_or_named_as_not_modelled():
    found = describe_model(ROUGH)
    assert {*found.modelled, *found.not_modelled} == {effect.phrase for effect in EFFECTS}
    assert not {*found.modelled} & {*found.not_modelled}


def test_a_delay_alone_of_these_effects_takes_part_in_the_margins():
    found = describe_model(ROUGH)
    # a delay has a linearisation and stays, the others have none
    assert smooth_part(ROUGH) == configure({'plant': {'delay.velocity_steps': 2}})
    assert (smooth_part(IDEAL), pattern_of(ROUGH), drive_of(ROUGH)) == (IDEAL, 1, 'torque')
    assert set(found.not_in_margins) == set(found.modelled) - {'dead time of the motors'}


def test_scenarios_count_in_place_of_the_configuration():
    nominal = configured_scenario(ROUGH)
    spread = [nominal._replace(delay=delay, noise=Noise(velocity=0.3)) for delay in (3, 0, 1)]
    found = describe_scenarios(ROUGH, spread)
    assert found.modelled['dead time of the motors'] == '0 to 3 velocity periods'
    assert found.modelled['noise'] == '0 m and 0 m and 0 rad and 0.3 rad/s'
    none = describe_scenarios(ROUGH, [nominal._replace(delay=0, noise=Noise())])
    assert {'dead time of the motors', 'noise'} < set(none.not_modelled)


def test_a_base_names_its_own_effects_and_none_of_motors():
    base = configure({'plant': {'drive': 'velocity', 'base.lag': [0.15, 0.1], 'base.max_speed': [0.7, 2.0],
                                'odometry.latency': 0.06, 'odometry.rate': 30.0}})
    found = describe_model(base)
    assert found.modelled == {'lag of the base': '0.15 and 0.1 s', 'latency of odometry': '0.06 s',
                              'rate of odometry': '30 Hz', 'limit of the speed': '0.7 m/s and 2 rad/s'}
    assert 'dead time of the base' in found.not_modelled
    assert 'Coulomb friction' not in found.not_modelled
    assert found.not_in_margins == ('limit of the speed',)
    assert drive_of(base) == 'velocity'
    # the delays of scenarios are dead time
    base = configure({'plant': {'drive': 'velocity', 'base.dead_time': [0.06, 0.02]}})
    found = describe_scenarios(base, [configured_scenario(base)._replace(delay=delay) for delay in (0, 8)])
    assert found.modelled == {'dead time of the base': '0.06 and 0.02 s and 0 to 8 velocity periods'}
    assert not any('motors' in phrase for phrase in (*found.not_modelled, *found.unknown))
    # and their friction is that of the motors
    nominal = configured_scenario(configure({}))
    found = describe_scenarios(configure({}), [rubbed(nominal, coulomb) for coulomb in (0.0, 0.2)])
    assert found.modelled['Coulomb friction'] == '0 to 0.2 N m'


BASE_EFFECTS = {
    'lag of the base': 'base.lag', 'dead time of the base': 'base.dead_time', 'unlike wheels': 'base.wheel_gain',
    'rate at which the base takes commands': 'base.command_rate', 'jitter of commands and odometry': 'odometry.jitter',
    'latency of odometry': 'odometry.latency', 'rate of odometry': 'odometry.rate', 'dead zone': 'base.dead_zone',
    'turn lost by skidding': 'base.turn_gain', 'drift and slip of odometry': 'odometry.dead_reckoning',
    'limit of the speed': 'base.max_speed', 'limit of the acceleration': 'base.max_acceleration',
}
A_VALUE = {'base.command_rate': 20.0, 'odometry.jitter': 0.02, 'odometry.latency': 0.06, 'odometry.rate': 30.0,
           'base.turn_gain': 0.9, 'base.wheel_gain': [1.0, 0.95], 'odometry.dead_reckoning': True}


def test_every_effect_of_a_base_is_warned_of_until_it_is_modelled_or_ruled_out():
    def unknown(**values):
        text = ' '.join(warnings_of(promised(configuration=configure({'plant': {'drive': 'velocity', **values}}))))
        return {effect.phrase for effect in EFFECTS if f'{effect.phrase} (' in text}

    assert unknown() == set(BASE_EFFECTS)
    for phrase, name in BASE_EFFECTS.items():
        assert unknown(ruled_out=name) == {*BASE_EFFECTS} - {phrase}
        if name != 'odometry.dead_reckoning':  # what drifts has a number beside it
            value = A_VALUE.get(name, [0.06, 0.08])
            assert unknown(**{name: value}) == {*BASE_EFFECTS} - {phrase}
    assert not warnings_of(promised(configuration=configure({'plant': {
        'drive': 'velocity', 'ruled_out': ', '.join(BASE_EFFECTS.values())}})))


@pytest.mark.parametrize(('values', 'ruled_out'), [
    ({'odometry.jitter': 0.02}, 'base.command_jitter'), ({'base.command_jitter': 0.02}, 'odometry.jitter'),
    ({'base.max_deceleration': [1.0, 2.0]}, 'base.max_acceleration'),
    ({'noise.velocity': 0.1}, 'noise.pose'), ({}, 'base.lag'),
])
def test_an_effect_is_listed_once_though_another_one_of_its_parameters_is_ruled_out(values, ruled_out):
    found = describe_model(configure({'plant': {'drive': 'velocity', 'ruled_out': ruled_out, **values}}))
    listed = [*found.modelled, *found.ruled_out, *found.not_modelled]
    assert len(listed) == len(set(listed))
    assert len(found.ruled_out) == (not values)


def test_what_is_ruled_out_is_a_parameter_that_is_off():
    def refused(**values):
        with pytest.raises(ParameterError) as refusal:
            configure({'plant': {'drive': 'velocity', **values}})
        return str(refusal.value)

    assert "the plant has no parameter 'base.dead'; did you mean 'base.dead_zone'?" in refused(ruled_out='base.dead')
    assert 'ruled_out: base.lag is not off' in refused(ruled_out='base.lag', **{'base.lag': [0.1, 0.0]})


@pytest.mark.parametrize(('changed', 'warning'), [
    ({'gain': 1.99}, 'position loop has a thin gain margin, 1.99'),
    ({'lowest': 0.51}, 'position loop has a thin lower gain margin, 0.51'),
    # 50 ms are 5 periods
    ({'delay': 4.99}, 'position loop has a thin delay margin, 49.9 ms'),
    # 2 velocity periods, and 4 on the wall clock
    ({'delay': 1.99}, 'velocity loop has a thin delay margin, 4.0 ms'),
    ({'delay': 3.99, 'lockstep': False}, 'velocity loop has a thin delay margin, 8.0 ms'),
    ({'gain': 1.0, 'delay': 0.0}, 'position loop is not stable at t = 1 s of the lap'),
    ({'reason': 'the motion diverges'}, 'the margins are unknown: the motion diverges'),
])
def test_thin_margins_are_warned_of_and_otherwise_only_what_is_not_modelled(changed, warning):
    assert any(warning in text for text in warnings_of(promised(**changed)))
    found, = warnings_of(promised())
    assert found.startswith('not modelled, and a robot with any of these effects may have another error: dead '
                            'time of the motors (step the torque and take the time until joint_states change); lag of '
                            'the motors (')
    assert found.endswith('Measure each on your robot, then set its parameter, or name it in plant.ruled_out; there is '
                          'room for 100 ms of delay before the loop is unstable')
    assert warnings_of(promised(delay=math.inf))[0].endswith('name it in plant.ruled_out')


def test_the_lines_are_short_and_name_margins_with_their_places():
    lines = promise_lines(promised(lowest=0.25, configuration=ROUGH))
    assert max(map(len, lines)) <= 100
    text = ' '.join(line.strip() for line in lines)
    assert 'modelled: dead time of the motors (2 velocity periods); limit of the torque (3 N m, 2.5 N m)' in text
    assert 'a robot with any of these effects may have another error' in text
    assert ('position loop: gain margin 5.00 at t = 1 s of the lap, lower gain margin 0.25, delay margin 100 ms '
            '(10.0 position periods) at t = 2 s of the lap') in text
    assert 'velocity loop: gain margin 5.00 at t = 1 s of the lap, lower gain margin 0.25, delay margin 20 ms' in text
    assert 'not in the margins: limit of the torque; limit of the speed; limit of the acceleration; noise' in text


def test_in_short_each_effect_stands_once_for_several_loops_after_all_warnings():
    one, other = promised(gain=1.5), promised(lowest=0.6)
    lines = brief_lines([one, other])
    text = ' '.join(line.strip() for line in lines)
    assert [text.count(f'{phrase}; ') for phrase in one.described.not_modelled[:-1]] == [1] * (
        len(one.described.not_modelled) - 1)
    assert text.count('plant.ruled_out') == text.count(' modelled: none') == 1
    assert 'thin gain margin, 1.50' in lines[0]
    assert text.count('position loop: ') == 2
    assert text.count('velocity loop: ') == 2


def test_what_is_beyond_the_search_and_what_is_unknown_is_told():
    text = '\n'.join(promise_lines(promised(gain=math.inf, delay=math.inf)))
    assert 'gain margin more than 20, delay margin 200 ms (more than 20 position periods)' in text
    unknown = LapMargins(UNKNOWN, math.nan, math.nan)
    found = promised()._replace(margins=LoopMargins(None, unknown, 'the motion diverges'))
    text = '\n'.join(promise_lines(found))
    assert 'velocity loop' not in text
    assert 'position loop: margins unknown' in text
    unstable = promised()._replace(margins=LoopMargins(None, LapMargins(UNSTABLE, 3.0, 3.0)))
    assert 'position loop: not stable at t = 3 s of the lap' in promise_lines(unstable)


def test_the_values_are_json_in_si_units():
    found = promise_values(promised(lowest=0.25, delay=math.inf))
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found['margins']['position_loop'] == {
        'gain': 5.0, 'lowest_gain': 0.25, 'gain_time': 1.0, 'delay': None, 'delay_time': 2.0}
    assert promise_values(promised())['margins']['velocity_loop']['delay'] == pytest.approx(0.02)
    assert found['modelled'] == {}
    assert 'latency of odometry' in found['not_modelled']
    assert found['warnings'] == warnings_of(promised(lowest=0.25, delay=math.inf))
    found = promised()._replace(spread=(0.01, 0.012, 0.02))
    assert 'RMS error of the configured run over 3 seeds: 1.20 cm, from 1.00 to 2.00 cm' in promise_lines(found)
    assert promise_values(found)['rms_position_error_over_seeds'] == [0.01, 0.012, 0.02]
