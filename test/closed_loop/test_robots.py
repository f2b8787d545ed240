"""Every robot of this package drives one lap of its curve, within a bound of its true error."""


import pytest

from mobile_robot_control.loop.batch import run_trials
from mobile_robot_control.loop.trial import make_trial
from mobile_robot_control.settings.configure import at_cart_start, configure, shipped_robots
from mobile_robot_control.settings.files import load

BOUNDS = {'chapter': (0.015, 0.04), 'create3': (0.012, 0.02), 'jackal': (0.1, 0.18), 'kobuki': (0.025, 0.06),
          'turtlebot3_burger': (0.02, 0.04), 'turtlebot3_burger_base': (0.022, 0.04),
          'turtlebot3_waffle': (0.012, 0.02), 'turtlebot4': (0.012, 0.02)}
"""[m]: RMS error of a lap from rest on the path, and the largest; odometry drifts in it."""


def test_every_robot_has_a_bound():
    assert set(BOUNDS) == set(shipped_robots())


@pytest.mark.parametrize('robot', BOUNDS)
def test_a_robot_drives_a_lap_within_its_bound(robot):
    parameters = at_cart_start(configure(load([shipped_robots()[robot]])))
    period = parameters.reference_cart.curve.placement.period
    trial = make_trial(parameters, period, late=0.0)
    outcome, = run_trials([trial], False)
    rms, largest = BOUNDS[robot]
    assert outcome.steps == trial.steps
    assert 0.0 < outcome.totals.squared_position < rms**2 * outcome.totals.time
    assert outcome.totals.max_position < largest
