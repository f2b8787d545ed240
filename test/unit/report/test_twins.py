"""A real run and its simulated twin: one time base, and how far they are apart."""

import json

import numpy as np
import pytest
from helpers.harness import CONFIG

import mobile_robot_control as mrc
from mobile_robot_control.report.report_writing import write_report
from mobile_robot_control.report.twins import with_twins
from mobile_robot_control.runs.series import Series, Signal

WALL, WAITED = 1_790_000_000_000_000_000, 3_000_000_000
FILE = CONFIG / 'wall_clock.yaml'


def simulated(name, lag, **more):
    return mrc.simulate(FILE, duration=8.0, parameters={
        '/**.lockstep': True, 'plant.drive': 'velocity', 'plant.base.lag': [lag, lag], **more})._replace(name=name)


def on_the_wall_clock(run):
    """Return a run as a bag has it in which the cart has waited at its start for 3 s."""
    signals = {}
    for topic, signal in run.series.signals.items():
        stamps, values = signal.stamps + WALL + WAITED, signal.values
        if topic in ('reference', 'odom', 'tracking_error'):
            stamps = np.concatenate([WALL + np.arange(0, WAITED, 20_000_000), stamps])
            values = np.concatenate([np.repeat(values[:1], stamps.size - len(values), axis=0), values])
        signals[topic] = Signal(stamps, stamps, values)
    return run._replace(series=Series(signals))


@pytest.fixture(scope='module')
def twins():
    return on_the_wall_clock(simulated('real', 0.2)), simulated('simulated', 0.15)


def test_twins_come_on_one_time_base_and_their_difference_is_told(quick, twins, tmp_path):
    real, twin = twins
    (moved, _), found = with_twins([real, twin])
    assert found.shift == pytest.approx(3.0, abs=0.01)
    assert found.references_apart < 0.01
    at = np.arange(found.begin, found.end, 0.1)
    assert found.begin == pytest.approx(2.0, abs=0.1)
    assert 0.0 < found.rms_heading < 0.2
    apart = [np.interp(at, moved.time, moved.pose[:, n]) - np.interp(at, twin.time, twin.pose[:, n]) for n in (0, 1)]
    assert found.rms_position == pytest.approx(np.sqrt(np.mean(np.hypot(*apart)**2)), rel=0.1)
    assert found.real_error > found.simulated_error > 0.0
    page = write_report([real, twin], tmp_path, lambda _: None).read_text()
    assert found.sentence in page
    assert json.loads((tmp_path / 'report.json').read_text())['real less simulated']['shift'] == found.shift


def test_twins_on_different_curves_are_told_so_and_other_names_are_left_alone(twins):
    real, twin = twins
    _, found = with_twins([real, simulated('simulated', 0.2, **{'reference_cart.curve': 'lemniscate'})])
    assert 'this compares different motions' in found.sentence
    runs = [real, twin._replace(name='other')]
    assert with_twins(runs) == (runs, None)


def test_twins_without_a_common_time_are_told_so(twins):
    real, twin = twins
    alone = Series({topic: signal for topic, signal in real.series.signals.items() if topic != 'reference'})
    (told, _), found = with_twins([real._replace(series=alone), twin])
    assert found is None
    assert 'is not put beside the simulated run' in told.problems[-1]
