"""A base that takes velocity commands: each departure from the ideal by hand, the lag against an independent solver."""

import math

import pytest
from each import each_row
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mobile_robot_control.model import dynamics
from mobile_robot_control.model.base import Base, base_violations, discretise_base, queue_length
from mobile_robot_control.model.base_motion import base_at_rest, base_step
from mobile_robot_control.model.events import periods
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose

MS = 1_000_000
ORIGIN = Pose(0.0, 0.0, 0.0)
ROBOT = Robot(wheel_radius=0.05, wheel_separation=0.4)


def drive(base, commands, period=2 * MS, position_period=10 * MS, start=ORIGIN):
    """Return the states at the beginning and after each step, one command a step."""
    discrete = discretise_base(base, ROBOT, period, position_period, 0)
    state, inner = dynamics.at_rest(start), base_at_rest(base, period, position_period)
    states = [state]
    for k, command in enumerate(commands):
        state, inner = base_step(state, inner, BodyVelocity(*command), k, discrete)
        states.append(state)
    return states


def speeds(states):
    return [state.velocity.linear for state in states[1:]]


def test_without_lag_it_is_the_ideal_unicycle_on_the_exact_arc():
    pose = Pose(1.0, -2.0, 0.7)
    states = drive(Base(), [(0.5, 1.3)] * 7, 33 * MS, 33 * MS, start=pose)
    for k, state in enumerate(states):
        exact = along_arc(pose, 0.5 * 0.033 * k, 1.3 * 0.033 * k)
        assert state.pose == pytest.approx(exact, abs=1e-14)
    assert states[1].velocity == BodyVelocity(0.5, 1.3)
    # v = r/2 (ω_R + ω_L), ω = r/(2R) (ω_R - ω_L)
    right, left = states[-1].right_angle, states[-1].left_angle
    assert 0.025 * (right + left) == pytest.approx(0.5 * 0.231)
    assert 0.05 * (right - left) / 0.4 == pytest.approx(1.3 * 0.231)


@each_row('lag', [(0.15, 0.15), (0.02, 0.3), (0.001, 0.0), (0.0, 0.05), (2e-3, 0.1)])
@each_row('period', [2 * MS, 33 * MS])
def test_with_lag_it_moves_as_an_independent_solver_says(lag, period):
    dt = period / 1e9
    commands = [(0.5, 1.0), (-0.3, 2.0), (0.7, -1.5)]
    states = drive(Base(lag=lag), commands, period, period)
    x = (0.0, 0.0, 0.0, 0.0, 0.0)
    for command, state in zip(commands, states[1:], strict=True):
        rates = [1.0 / one if one else 0.0 for one in lag]
        x = [*x[:3], *(now if one else to for now, to, one in zip(x[3:], command, lag, strict=True))]

        def slope(_, x, command=command, rates=rates):
            return (x[3] * math.cos(x[2]), x[3] * math.sin(x[2]), x[4],
                    rates[0] * (command[0] - x[3]), rates[1] * (command[1] - x[4]))

        x = solve_ivp(slope, (0.0, dt), x, method='DOP853', rtol=1e-12, atol=1e-14).y[:, -1]
        assert (*state.pose, *state.velocity) == pytest.approx(tuple(x), abs=2e-10 if dt < 0.01 else 1e-8)


def test_dead_time_is_rounded_up_to_a_velocity_period():
    assert periods(0.06, 2 * MS) == 30
    assert periods(0.0601, 2 * MS) == 31
    assert periods(0.0, 2 * MS) == 0
    commands = [(0.1 * (1 + k // 5), 0.0) for k in range(20)]
    # 5 ms are 3 periods of 2 ms, and commands are taken every 5 periods
    late = speeds(drive(Base(dead_time=(0.005, 0.0)), commands))
    assert late == pytest.approx([0.0] * 3 + [v for v, _ in commands[:17]])
    assert speeds(drive(Base(), commands)) == [v for v, _ in commands]


def test_without_a_rate_a_long_dead_time_keeps_the_commands_of_the_finest_grid_that_it_can():
    # 0.2 s hold 101 commands at 500 Hz, and 51 at every second tick of four in a position period
    base = Base(dead_time=(0.2, 0.0))
    assert queue_length(base, 2 * MS, 8 * MS) == 51
    states = drive(base, [(1.0 + k // 4, 0.0) for k in range(200)], position_period=8 * MS)
    assert speeds(states) == [0.0] * 100 + [1.0 + k // 4 for k in range(100)]


def test_limits_of_speed_and_acceleration():
    states = drive(Base(max_speed=(0.4, 1.0), max_acceleration=(50.0, 0.0)), [(0.9, -3.0)] * 5 + [(-0.9, 0.0)] * 3)
    assert speeds(states) == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.4, 0.3, 0.2, 0.1])
    assert [state.velocity.angular for state in states[1:]] == [-1.0] * 5 + [0.0] * 3


def test_dead_zone_and_quantisation():
    asked = [0.049, 0.05, -0.049, -0.051, 0.2]
    assert speeds(drive(Base(dead_zone=(0.05, 0.0)), [(v, 0.0) for v in asked], 2 * MS, 2 * MS)) == [
        0.0, 0.05, 0.0, -0.051, 0.2]
    assert speeds(drive(Base(quantum=(0.02, 0.0)), [(v, 0.0) for v in asked], 2 * MS, 2 * MS)) == pytest.approx([
        0.04, 0.06, -0.04, -0.06, 0.2])


def test_a_base_brakes_harder_than_it_speeds_up():
    base = Base(max_acceleration=(50.0, 0.0), max_deceleration=(100.0, 0.0))
    assert speeds(drive(base, [(0.3, 0.0)] * 3 + [(-0.3, 0.0)] * 4)) == pytest.approx(
        [0.1, 0.2, 0.3, 0.1, -0.1, -0.2, -0.3])


def test_unlike_wheels_turn_and_skidding_ones_turn_less():
    # rims at v ± R ω with R = 0.2 m: the right one 10 % faster than commanded
    states = drive(Base(wheel_gain=(1.1, 1.0)), [(0.4, 0.5)])
    assert states[-1].velocity == pytest.approx((0.5 * (1.1 * 0.5 + 0.3), (1.1 * 0.5 - 0.3) / 0.4))
    states = drive(Base(turn_gain=0.7, lag=(0.002, 0.002)), [(0.4, 0.5)] * 50)
    assert states[-1].velocity == pytest.approx((0.4, 0.35))


def test_jitter_delays_each_command_by_up_to_its_length():
    base = Base(command_jitter=0.01)
    states = drive(base, [(float(k), 0.0) for k in range(2000)])
    # the newest that acts: at most five periods old, and as often late as not
    late = [k - one for k, one in enumerate(speeds(states))][10:]
    assert {*late} == {0.0, 1.0, 2.0, 3.0, 4.0, 5.0}
    assert speeds(drive(base, [(float(k), 0.0) for k in range(2000)])) == speeds(states)
    alone = drive(Base(command_jitter=0.01, command_rate=20.0), [(float(k), 0.0) for k in range(2500)])
    taken = [k for k, (now, before) in enumerate(zip(speeds(alone)[1:], speeds(alone), strict=False)) if now != before]
    delays = [k + 1 - 25 * n for n, k in enumerate(taken, start=1)]
    assert min(delays) == 0
    assert max(delays) == 5
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

    discrete = discretise_base(base, ROBOT, period, ratio * period, 0)
    state, inner = dynamics.at_rest(Pose(0.0, 0.0, 0.0)), base_at_rest(base, period, ratio * period)
    assert len(inner.commands) == queue_length(base, period, ratio * period)
    for k, command in enumerate(commands):
        state, inner = base_step(state, inner, BodyVelocity(*command), k, discrete)
        assert inner.setpoint == tuple(followed(k, periods(dead_time[n], period), n) for n in (0, 1))


def test_commands_without_end_are_refused_in_the_words_of_what_is_given():
    plain, = base_violations(Base(dead_time=(30.0, 0.0), command_rate=100.0), 2 * MS, 10 * MS)
    assert plain.startswith('base.dead_time = [30.0, 0.0] s has more than')
    late, = base_violations(Base(dead_time=(30.0, 0.0), command_rate=100.0, command_jitter=0.5), 2 * MS, 10 * MS)
    assert late.startswith('base.dead_time = [30.0, 0.0] s with base.command_jitter = 0.5 s has more than')
