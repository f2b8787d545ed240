"""Performance indices: integrals of the position error, settling, and total variation, with hand numbers."""

import math

import pytest
from each import each_row
from measuring import configuration

from mobile_robot_control.quantities import (
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.simulation.closed_loop import PositionTick, Sample
from mobile_robot_control.simulation.index_meter import IndexMeter
from mobile_robot_control.simulation.metric_table import BAND, INDICES
from mobile_robot_control.simulation.metrics import RunMeter, summary
from mobile_robot_control.simulation.rollout import measure, rollout

STILL, ORIGIN = BodyVelocity(0.0, 0.0), Pose(0.0, 0.0, 0.0)
UNKNOWN = WheelTorque(math.nan, math.nan)
KNOWN = configuration(reference_cart={'curve': 'line'})
"""With a robot whose wheels are 0.35 m apart, and a cart that starts at the origin along x."""


def samples(errors, torques=(), commands=()):
    """Yield a sample a second, at each of which there is a position tick, with e2 as given and the cart at rest."""
    for k, aside in enumerate(errors):
        tick = PositionTick(float(k), ORIGIN, STILL, Reference(ORIGIN, STILL), TrackingError(0.0, aside, 0.0))
        yield Sample(float(k), tick, commands[k] if commands else STILL, 0.0, 0.0, WheelVelocity(0.0, 0.0),
                     torques[k] if torques else WheelTorque(0.0, 0.0), UNKNOWN)


def metrics(given, parameters=None, outcome='completed'):
    meter = RunMeter(1.0, 1.0, indices=IndexMeter(1.0, parameters))
    for sample in given:
        meter.add(sample)
    return summary(meter.run(outcome))


def test_the_integrals_are_sums_over_the_ticks_before_the_end():
    found = metrics(samples([0.3, -0.5, 0.1, 9.0]))
    assert found['iae'] == pytest.approx(0.3 + 0.5 + 0.1, rel=1e-15)
    assert found['ise'] == pytest.approx(0.09 + 0.25 + 0.01, rel=1e-15)
    assert found['itae'] == pytest.approx(0.5 + 2.0 * 0.1, rel=1e-15)
    assert found['itse'] == pytest.approx(0.25 + 2.0 * 0.01, rel=1e-15)
    assert found['ise'] == pytest.approx(3.0 * found['rms_position_error']**2, rel=1e-15)


IN, OUT = 0.5 * BAND, 2.0 * BAND


@each_row(('errors', 'settling', 'share'), [
    ([OUT, IN, OUT, IN, IN], 3.0, 0.5), ([OUT, OUT, BAND, -BAND, OUT], 2.0, 0.5),
    # never outside, never inside, outside at the last tick that counts
    ([IN, IN, IN], 0.0, 1.0), ([OUT, OUT, IN], None, 0.0), ([IN, IN, IN, OUT, IN], None, 0.75),
])
def test_an_error_has_settled_from_the_tick_on_after_which_it_stays_within_the_band(errors, settling, share):
    found = metrics(samples(errors))
    assert found['settling_time'] == settling
    assert found['share_within_band'] == share


@each_row(('outcome', 'settling'), [
    ('completed', 1.0), ('interrupted', 1.0), ('broken off', 1.0), ('not known', 1.0),
    ('diverged', None), ('law_failed', None), ('node_died', None),
])
def test_the_error_of_a_run_that_failed_has_not_settled(outcome, settling):
    found = metrics(samples([OUT, IN, IN]), outcome=outcome)
    assert found['settling_time'] == settling
    assert found['iae'] == OUT + IN


def test_of_a_single_sample_nothing_has_an_index():
    found = metrics(samples([IN]), KNOWN)
    assert {name for name in INDICES if found[name] is None} == {*INDICES} - {'torque_variation', 'command_variation'}


def test_the_true_error_and_pose_are_measured_where_they_are_known():
    shown = list(samples([OUT, OUT, OUT]))
    truth = Truth(Pose(0.1, -0.3, 0.0), STILL, TrackingError(0.0, 0.3, 0.0))
    gone = Truth(Pose(math.nan, math.nan, math.nan), STILL, TrackingError(math.nan, math.nan, math.nan))
    known = metrics([shown[0]._replace(truth=truth), shown[1]._replace(truth=gone), shown[2]], KNOWN)
    assert known['iae'] == 0.3
    # the cart is at the origin of the line, of which 0.1 m is within a quarter lap
    assert known['rms_cross_track_error'] == known['max_cross_track_error'] == pytest.approx(0.3, rel=1e-12)


def test_the_variations_are_sums_of_changes_from_rest():
    torques = [WheelTorque(*pair) for pair in ((0.0, 0.0), (2.0, -1.0), (1.0, -1.0), (1.0, 3.0))]
    commands = [BodyVelocity(*pair) for pair in ((0.5, 0.0), (0.5, 0.0), (0.1, 2.0), (9.0, 9.0))]
    found = metrics(samples([IN] * 4, torques, commands), KNOWN)
    assert found['torque_variation'] == 3.0 + 1.0 + 4.0
    # both rims: 0.5 m/s each, then 0.1 + 0.35 and 0.1 - 0.35 m/s
    assert found['command_variation'] == pytest.approx(2.0 * 0.5 + 0.05 + 0.75, rel=1e-12)


def test_torques_that_are_not_known_have_no_variation():
    found = metrics(samples([IN] * 3, [UNKNOWN] * 3, [BodyVelocity(0.5, 0.0)] * 3), KNOWN)
    assert found['torque_variation'] is None
    assert found['command_variation'] == 1.0
    # one that is missing counts as unchanged
    torques = [UNKNOWN, WheelTorque(2.0, 0.0), UNKNOWN, WheelTorque(3.0, 0.0)]
    assert metrics(samples([IN] * 4, torques), KNOWN)['torque_variation'] == 3.0


def test_the_largest_cross_track_error_is_not_known_where_one_is_not():
    first, *others = samples([0.3, 0.1, 0.1])
    away = Reference(Pose(0.0, 5.0, 0.0), STILL)
    off = [sample._replace(tick=sample.tick._replace(reference=away)) for sample in others]
    found = metrics([first, *off], KNOWN)
    assert found['rms_cross_track_error'] is found['max_cross_track_error'] is None
    assert found['iae'] == 0.4


def test_a_robot_that_stands_while_the_cart_drives_a_lap_of_a_circle():
    parameters = configuration(
        plant={'drive': 'velocity', 'base.dead_zone': [9.0, 9.0], 'initial_pose': [1.0, 0.0, 1.5]},
        reference_cart={'curve': 'circle', 'period': 2.0})
    last = list(rollout(parameters, 2.0))[-1]
    assert last.tick.pose[:2] == (1.0, 0.0)
    found = summary(measure(parameters, 2.0))
    assert found['max_position_error'] == pytest.approx(2.0)
    # the chord to the nearer end of the quarters, which is longest when the cart is opposite
    assert found['max_cross_track_error'] == pytest.approx(math.sqrt(2.0), abs=1e-8)
    chords = [2.0 * math.sin(math.pi * max(0.0, min(n, 200 - n) / 200 - 0.25)) for n in range(200)]
    rms = math.sqrt(sum(chord**2 for chord in chords) / 200)
    assert found['rms_cross_track_error'] == pytest.approx(rms, abs=1e-8)
    # a tick before the cart is back it is 3 cm away
    assert found['settling_time'] is None
