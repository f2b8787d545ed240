"""Time series of runs: torque, power and energy, thinning, headings, timing over DDS, animation, legends."""

import math

import numpy as np
import pytest
from helpers.measuring import configuration, measured

from mobile_robot_control.figures.drawing import draw
from mobile_robot_control.figures.figure import Line, broken_at_jumps, thinned
from mobile_robot_control.report.report_writing import (
    TIMING_FIGURES,
    intervals,
    intervals_in_motion,
    latency,
    quantiles,
    timed,
    timing_table,
)
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import Messages, collect
from mobile_robot_control.runs.series import Series

WALL = 1_790_000_000_000_000_000


def _named(name, series):
    return Run(name, series, (), {}, None)


@pytest.fixture(scope='module')
def fuzzy():
    return configuration(position_controller={'controller_type': 'fuzzy'})


@pytest.fixture(scope='module')
def series(fuzzy):
    return collect(rollout(fuzzy, 1.0))


def test_peaks_and_energy_equal_the_metrics(fuzzy, series):
    metrics, _ = measured(fuzzy, 1.0)
    for wheel in ('right', 'left'):
        assert np.abs(series.torque(wheel).value).max() == metrics['peak_wheel_torque'][wheel]
        assert np.abs(series.power(wheel).value).max() == metrics['peak_wheel_power'][wheel]
    assert series.energy().value[-1] == pytest.approx(metrics['energy'], rel=1e-9)
    assert series.energy().time[-1] == 1.0


@pytest.mark.parametrize('origin', [0, WALL])
def test_until_keeps_the_times_of_receipt_and_nothing_gives_empty_lines(origin):
    part = _recorded(origin).until(0.5)
    assert part.time('odom')[-1] == pytest.approx(0.5)
    assert intervals(part, 'odom').value.size == 50
    empty = Series({})
    for line in (empty.line('odom', 'x'), empty.torque('right'), empty.energy(), empty.power('left'),
                 *empty.headings()):
        assert line.time.size == line.value.size == 0
    assert not timed(empty)


def test_a_thinned_line_keeps_every_peak_both_ends_and_the_jumps_of_a_wrapped_angle():
    value = np.sin(np.arange(1e5) / 900.0)
    places = [1, 4999, 50_000, 99_998]
    value[places] = 7.0
    line = thinned(Line(np.arange(1e5), value))
    assert line.time.size < 3000
    assert line.time[line.value == 7.0].tolist() == places
    assert (line.time[0], line.time[-1]) == (0.0, 99_999.0)
    assert (np.diff(line.time) > 0.0).all()
    time = np.arange(20_000) / 1000.0
    line = broken_at_jumps(Line(time, np.angle(np.exp(1j * time))))
    assert np.isnan(line.value).sum() == 3
    assert np.isnan(thinned(line).value).sum() == 3


def test_headings_are_continuous_and_without_whole_turns_between_them():
    robot, cart = collect(rollout(configuration(plant={'initial_pose': [1.0, 0.0, 0.5 * math.pi - 2.0 * math.pi]}),
                                  2.0)).headings()
    assert np.abs(np.diff(robot.value)).max() < 0.2
    assert np.abs(robot.value - cart.value).max() < 1.0


def _recorded(origin, wait=0):
    """
    A run whose cmd_vel comes 3 ms and whose wheel torques come 1 ms after the question; one answer is 50 ms late.

    The messages of the first stamp are received a wait [ns] earlier.
    """
    received_by = Messages()
    for n in range(101):
        elapsed = n * 10_000_000
        stamp, received, late = origin + elapsed, WALL + elapsed - (0 if n else wait), 50_000_000 if n == 50 else 0
        received_by.add('odom', stamp, [0.0] * 5, received)
        received_by.add('cmd_vel', stamp + (3_000_000 if origin else 0), [0.0] * 2, received + 3_000_000 + late)
        received_by.add('joint_states', stamp, [0.0] * 6, received)
        received_by.add('wheel_torques', stamp, [0.0] * 2, received + 1_000_000)
    return Series(received_by.last_run().signals)


@pytest.mark.parametrize('origin', [0, WALL])
def test_intervals_and_latencies_are_those_of_the_recorders_clock(origin):
    run = _recorded(origin)
    assert timed(run)
    assert quantiles(intervals(run, 'odom').value).median == pytest.approx(10.0, rel=1e-3)
    assert quantiles(latency(run, 'joint_states', 'wheel_torques').value).largest == pytest.approx(1.0, rel=1e-3)
    answers = quantiles(latency(run, 'odom', 'cmd_vel').value)
    assert answers.median == pytest.approx(3.0, rel=1e-3)
    # in lockstep a late answer is late; on the wall clock it is the answer to the newest question by then
    assert answers.largest == pytest.approx(3.0 if origin else 53.0, rel=1e-3)
    assert '<td class=number>101</td>' in timing_table(run)


def test_the_wait_at_stamp_0_is_in_the_table_and_not_in_the_figure_of_intervals():
    run = _recorded(0, wait=4_000_000_000)
    assert intervals(run, 'odom').value[0] == pytest.approx(4010.0, rel=1e-3)
    assert '4.01e+03 ms' in timing_table(run)
    assert intervals_in_motion(_recorded(WALL), 'odom').value.size == 100
    moving = intervals_in_motion(run, 'odom')
    assert moving.time.size == moving.value.size == 99
    assert moving.value == pytest.approx(10.0, rel=1e-3)
    for axes in draw(TIMING_FIGURES[0].of_runs([_named('run', run)])).axes:
        assert axes.get_ylim()[1] < 20.0
