"""The promise of a plant like the stand-in base, on the base as a node on the wall clock."""

import math
import subprocess
import sys
from pathlib import Path

import late_base
import numpy as np
import pytest
from harness import CONFIG
from nav_msgs.msg import Odometry
from promising import TUNED, fed, plant_like, promised
from stand_in_model import Base

from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES

LAP = 16.0


def by_time(messages):
    """Return stamps [s], x and y of odometry messages, each as an array."""
    return np.array([[message.header.stamp.sec + message.header.stamp.nanosec / 1e9, message.pose.pose.position.x,
                      message.pose.pose.position.y] for message in messages]).T


@pytest.mark.soak
@pytest.mark.parametrize(('given', 'bound'), [(TUNED, 0.015), ([*TUNED, *fed(0.15)], 0.005)], ids=['', 'feedforward'])
def test_tuned_gains_keep_their_promise_on_a_base_of_its_own_on_the_wall_clock(robot, given, bound):
    parameters = plant_like(Base(), 'trifolium', given)
    truth, cart = [], []
    for topic, found in (('ground_truth', truth), ('reference', cart)):
        robot.recorder.create_subscription(Odometry, topic, found.append, 100)
    curve = parameters.reference_cart.curve
    start = reference_at(CURVES[curve.curve], 0.0, curve.placement).pose
    base = subprocess.Popen([sys.executable, Path(late_base.__file__), '--lag', '0.15', '--pose', *map(str, start)])
    try:
        robot.start('position_controller', 'reference_cart', arguments=[
            '--params-file', CONFIG / 'wall_clock.yaml', '-p', 'odometry_stamped:=sampled',
            *(word for one in given
              for word in ('-p', one.removeprefix('/**.').replace('controller.', 'controller:')))])
        robot.spin_until(lambda: len(cart) > 50 * 2.5 * LAP, 60.0)
    finally:
        base.kill()
        base.wait()
    stamps, x, y = by_time(cart)
    then, true_x, true_y = by_time(truth)
    late = stamps > stamps[0] + 10.0
    apart = np.hypot(np.interp(stamps[late], then, true_x) - x[late], np.interp(stamps[late], then, true_y) - y[late])
    rms = math.sqrt(float((apart**2).mean()))
    print(f'RMS error {100.0 * rms:.2f} cm, promised {100.0 * promised(parameters):.2f} cm')
    assert rms < bound
    assert rms == pytest.approx(promised(parameters), rel=0.3, abs=0.0015)
