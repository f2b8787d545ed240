"""A base that takes velocity commands: each departure from the ideal by hand, the lag against an independent solver."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mobile_robot_control.model import dynamics
from mobile_robot_control.model.base import (
    Base,
    base_at_rest,
    base_step,
    base_violations,
    discretise_base,
    queue_length,
)
from mobile_robot_control.model.events import periods
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose

MS = 1_000_000
ROBOT = Robot(wheel_radius=0.05, wheel_separation=0.4)


def stepped(base, commands, period=2 * MS, position_period=10 * MS, start=Pose(0.0, 0.0, 0.0)):  # noqa: B008
    """Yield the state of the plant and of the base after each step, one command a step."""
    discrete = discretise_base(base, ROBOT, period, position_period, 0)
    state, inner = dynamics.at_rest(start), base_at_rest(base, period, position_period)
    for k, command in enumerate(commands):
        state, inner = base_step(state, inner, BodyVelocity(*command), k, discrete)
        yield state, inner


def drive(*args, **more):
    return [state for state, _ in stepped(*args, **more)]


def speeds(base, commands, *periods_):
    """Return the linear velocity after each step of linear commands."""
    return [state.velocity.linear for state in drive(base, [(v, 0.0) for v in commands], *periods_)]


def test_without_lag_it_is_the_ideal_unicycle_on_the_exact_arc():
    pose = Pose(1.0, -2.0, 0.7)
    states = drive(Base(), [(0.5, 1.3)] * 7, 33 * MS, 33 * MS, start=pose)
    for k, state in enumerate(states, start=1):
        assert state.pose == pytest.approx(along_arc(pose, 0.5 * 0.033 * k, 1.3 * 0.033 * k), abs=1e-14)
    assert states[0].velocity == BodyVelocity(0.5, 1.3)
    # v = r/2 (ω_R + ω_L), ω = r/(2R) (ω_R - ω_L)
    right, left = states[-1].right_angle, states[-1].left_angle
    assert 0.025 * (right + left) == pytest.approx(0.5 * 0.231)
    assert 0.05 * (right - left) / 0.4 == pytest.approx(1.3 * 0.231)


@pytest.mark.parametrize('lag', [(0.15, 0.15), (0.02, 0.3), (0.001, 0.0), (0.0, 0.05), (2e-3, 0.1)])
@pytest.mark.parametrize('period', [2 * MS, 33 * MS])
def test_with_lag_it_moves_as_an_independent_solver_says(lag, period):
    dt = period / 1e9
    commands = [(0.5, 1.0), (-0.3, 2.0), (0.7, -1.5)]
    rates = [1.0 / one if one else 0.0 for one in lag]
    x = (0.0, 0.0, 0.0, 0.0, 0.0)
    for command, state in zip(commands, drive(Base(lag=lag), commands, period, period), strict=True):
        x = [*x[:3], *(now if one else to for now, to, one in zip(x[3:], command, lag, strict=True))]

        def slope(_, x, command=command):
            return (x[3] * math.cos(x[2]), x[3] * math.sin(x[2]), x[4],
                    rates[0] * (command[0] - x[3]), rates[1] * (command[1] - x[4]))

        x = solve_ivp(slope, (0.0, dt), x, method='DOP853', rtol=1e-12, atol=1e-14).y[:, -1]
        assert (*state.pose, *state.velocity) == pytest.approx(tuple(x), abs=2e-10 if dt < 0.01 else 1e-8)


@pytest.mark.parametrize(('seconds', 'number'), [(0.06, 30), (0.0601, 31), (0.0, 0)])
def test_a_dead_time_is_rounded_up_to_a_velocity_period(seconds, number):
    assert periods(seconds, 2 * MS) == number


def test_without_a_rate_a_long_dead_time_keeps_commands_on_the_finest_grid_that_it_can():
    # 0.2 s hold 101 commands at 500 Hz, and 51 at every second tick of four in a position period
    base = Base(dead_time=(0.2, 0.0))
    assert queue_length(base, 2 * MS, 8 * MS) == 51
    assert speeds(base, [1.0 + k // 4 for k in range(200)], 2 * MS, 8 * MS) == [
        0.0] * 100 + [1.0 + k // 4 for k in range(100)]


@pytest.mark.parametrize(('base', 'asked', 'expected'), [
    # 5 ms are 3 periods of 2 ms, and commands are taken every 5 periods
    (Base(dead_time=(0.005, 0.0)), [0.1] * 5 + [0.2] * 5, [0.0] * 3 + [0.1] * 5 + [0.2] * 2),
    (Base(max_speed=(0.4, 1.0), max_acceleration=(50.0, 0.0)), [0.9] * 5 + [-0.9] * 3,
     [0.1, 0.2, 0.3, 0.4, 0.4, 0.3, 0.2, 0.1]),
    # it brakes harder than it speeds up
    (Base(max_acceleration=(50.0, 0.0), max_deceleration=(100.0, 0.0)), [0.3] * 3 + [-0.3] * 4,
     [0.1, 0.2, 0.3, 0.1, -0.1, -0.2, -0.3]),
])
def test_limits_and_dead_time_by_hand(base, asked, expected):
    assert speeds(base, asked) == pytest.approx(expected)


@pytest.mark.parametrize(('base', 'expected'), [
    (Base(dead_zone=(0.05, 0.0)), [0.0, 0.05, 0.0, -0.051, 0.2]),
    (Base(quantum=(0.02, 0.0)), [0.04, 0.06, -0.04, -0.06, 0.2]),
    (Base(max_speed=(0.05, 1.0)), [0.049, 0.05, -0.049, -0.05, 0.05]),
])
def test_dead_zone_quantisation_and_limit_of_each_command(base, expected):
    assert speeds(base, [0.049, 0.05, -0.049, -0.051, 0.2], 2 * MS, 2 * MS) == pytest.approx(expected)


@pytest.mark.parametrize(('base', 'command', 'velocity'), [
    # rims at v ± R ω with R = 0.2 m: the right one 10 % faster than commanded
    (Base(wheel_gain=(1.1, 1.0)), (0.4, 0.5), (0.5 * (1.1 * 0.5 + 0.3), (1.1 * 0.5 - 0.3) / 0.4)),
    (Base(turn_gain=0.7, lag=(0.002, 0.002)), (0.4, 0.5), (0.4, 0.35)),
    (Base(max_speed=(0.4, 1.0)), (0.9, -3.0), (0.4, -1.0)),
])
def test_unlike_wheels_turn_and_skidding_ones_turn_less(base, command, velocity):
    assert drive(base, [command] * 50)[-1].velocity == pytest.approx(velocity)


def test_jitter_delays_each_command_by_up_to_its_length():
    # the newest that acts: at most five periods old, and as often late as not
    late = [k - one for k, one in enumerate(speeds(Base(command_jitter=0.01), map(float, range(2000))))][10:]
    assert {*late} == {0.0, 1.0, 2.0, 3.0, 4.0, 5.0}
    alone = speeds(Base(command_jitter=0.01, command_rate=20.0), map(float, range(2500)))
    taken = [k for k in range(1, len(alone)) if alone[k] != alone[k - 1]]
    delays = [k - 25 * n for n, k in enumerate(taken, start=1)]
    assert (min(delays), max(delays)) == (0, 5)
    assert sum(delays) / len(delays) == pytest.approx(2.5, abs=0.5)


@settings(max_examples=40)
@given(
    st.tuples(*[st.sampled_from([0.0, 0.001, 0.0123, 0.1])] * 2), st.sampled_from([0.0, 7.0, 20.0, 30.0, 1000.0]),
    st.sampled_from([1, 3, 10]), st.tuples(*[st.sampled_from([0.0, 0.02, 0.3])] * 2),
)
def test_it_follows_the_newest_command_that_is_old_enough(dead_time, rate, ratio, lag):
    period = 2 * MS
    base = Base(dead_time=dead_time, command_rate=rate, lag=lag)
    commands = [(float(1 + k // ratio), float(-1 - k // ratio)) for k in range(150)]
    every = max(period, round(1e9 / rate)) if rate else period

    def followed(k, delay, n):
        taken = [tick for j in range(200) if (tick := -(-j * every // period)) <= k - delay]
        return commands[taken[-1]][n] if taken else 0.0

    assert len(base_at_rest(base, period, ratio * period).commands) == queue_length(base, period, ratio * period)
    for k, (_, inner) in enumerate(stepped(base, commands, period, ratio * period)):
        assert inner.setpoint == tuple(followed(k, periods(dead_time[n], period), n) for n in (0, 1))


@pytest.mark.parametrize(('jitter', 'words'), [(0.0, ''), (0.5, ' with base.command_jitter = 0.5 s')])
def test_commands_without_end_are_refused_in_the_words_of_what_is_given(jitter, words):
    one, = base_violations(Base(dead_time=(30.0, 0.0), command_rate=100.0, command_jitter=jitter), 2 * MS, 10 * MS)
    assert one.startswith(f'base.dead_time = [30.0, 0.0] s{words} has more than')
