"""The node's part of a cart that waits: the steady clock, the log and the diagnostics."""

import math
import types

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.ros.cart.cart_time import CartWait


class Cart:
    """A cart at a rate [Hz] that drives along x at 0.3 m/s; the test moves its steady clock and its odometry."""

    def __init__(self, rate):
        self.now, self.age, self.logged, self._period = 100.0, 0.0, [], 1.0 / rate
        log = types.SimpleNamespace(warning=self.logged.append, info=self.logged.append)
        monitor = types.SimpleNamespace(age=lambda topic: self.age, missing=lambda: [])
        self.wait = CartWait(
            types.SimpleNamespace(get_logger=lambda: log), types.SimpleNamespace(now=lambda: self.now), monitor, 0.5,
            self._period, lambda time: Reference(Pose(0.3 * time, 0.0, 0.0), BodyVelocity(0.3, 0.0)))
        self.wait.note(Pose(0.0, 0.0, 0.0))

    def run(self, seconds, follows=True):
        """Return the last reference; the robot is where the cart is, or stays."""
        for _ in range(round(seconds / self._period)):
            self.now += self._period
            reference = self.wait.references()[0]
            if follows:
                self.wait.note(reference.pose)
        return reference


@pytest.mark.parametrize('rate', [50.0, 4.0, 0.5])
def test_the_cart_drives_at_any_rate(rate):
    cart = Cart(rate)
    reference = cart.run(20.0)
    assert reference.velocity.linear == 0.3
    assert 0.3 * 18.0 < reference.pose.x <= 0.3 * 20.0
    assert cart.wait.condition() is None


def test_what_it_waits_for_is_logged_once_and_reported():
    cart = Cart(50.0)
    cart.run(5.0)
    assert cart.logged == ['the cart drives']
    cart.run(5.0, follows=False)
    words = cart.logged[1]
    assert words.startswith('the cart waits: the robot stands: 0.1')
    assert words.endswith(' m and 0.00 rad lie between robot and cart, which goes on within 0.1 m and 0.3 rad')
    condition = cart.wait.condition()
    assert (condition.level, condition.state) == (DiagnosticStatus.WARN, 'waiting')
    assert f'the cart waits: {condition.detail}' == words
    cart.age = math.inf
    cart.run(1.0, follows=False)
    assert cart.wait.condition().detail.startswith('odom is silent: ')
    cart.age = 0.0
    cart.wait.note(cart.wait.references()[0].pose)
    cart.run(1.0)
    assert cart.logged[2:] == ['the cart drives']


def test_a_node_that_was_held_up_finds_its_cart_where_it_was():
    cart = Cart(50.0)
    before = cart.run(5.0)
    cart.now += 3.0
    assert cart.wait.references()[0] == before._replace(velocity=BodyVelocity(0.0, 0.0))
    assert cart.run(1.5).velocity.linear == 0.3
