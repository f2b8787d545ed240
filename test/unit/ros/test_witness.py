"""For whom a lockstep run waits: asked for only when it waits long."""

import types

from mobile_robot_control.ros.peers import Witness


class StandInNode:
    """Counts the subscriptions that stand, and hears warnings."""

    def __init__(self):
        self.listeners, self.warnings = {}, []

    def create_subscription(self, kind, topic, callback, qos, raw):
        self.listeners[topic] = callback
        return topic

    def destroy_subscription(self, topic):
        del self.listeners[topic]

    def count_publishers(self, topic):
        return 1

    def get_logger(self):
        return types.SimpleNamespace(warning=self.warnings.append, info=self.warnings.append)


def test_a_short_stall_costs_no_subscriptions_and_a_long_one_is_named():
    node = StandInNode()
    witness = Witness(node, timeout=2.0)
    for silence in (0.1, 0.2, 0.4):
        witness.stalled(silence, 0, 0)
        assert not node.listeners
    witness.stalled(0.5, 0, 0)
    assert set(node.listeners) == {'reference', 'cmd_vel'}
    witness.stalled(1.9, 0, 0)
    assert not node.warnings
    witness.stalled(2.6, 0, 0)
    assert witness.named == ['reference_cart']
    assert 'waiting for reference_cart' in node.warnings[0]
    witness.progressed()
    assert not node.listeners
    assert 'answered' in node.warnings[1]


def test_a_short_timeout_listens_before_it_names():
    node = StandInNode()
    witness = Witness(node, timeout=0.2)
    witness.stalled(0.1, 0, 0)
    assert node.listeners
    assert not witness.named
