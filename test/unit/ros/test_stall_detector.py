"""The node that a stalled lockstep run waits for is determined only after a long stall."""

import types

from mobile_robot_control.ros.clocks.stall_detector import StallDetector
from mobile_robot_control.topics import LOOPS


class StandInNode:
    """Records subscriptions and warnings."""

    def __init__(self):
        self.listeners, self.warnings = {}, []

    def create_subscription(self, kind, topic, callback, qos, raw):
        self.listeners[topic] = callback
        return topic

    def count_publishers(self, topic):
        return 1

    def get_logger(self):
        return types.SimpleNamespace(warning=self.warnings.append, info=self.warnings.append)


def test_only_a_long_stall_adds_subscriptions_and_names_its_node():
    node = StandInNode()
    detector = StallDetector(node, timeout=2.0, loop=LOOPS['torque'])
    for silence in (0.1, 0.2, 0.4):
        detector.note_silence(silence, 0, 0)
        assert not node.listeners
    detector.note_silence(0.5, 0, 0)
    assert set(node.listeners) == {'reference', 'cmd_vel'}
    detector.note_silence(1.9, 0, 0)
    assert not node.warnings
    detector.note_silence(2.6, 0, 0)
    assert detector.named == ['reference_cart']
    assert 'waiting for reference_cart' in node.warnings[0]
    detector.note_progress()
    # a subscription that goes may leave DDS unable to discover the plant again
    assert set(node.listeners) == {'reference', 'cmd_vel'}
    assert 'answered' in node.warnings[1]


def test_a_short_timeout_subscribes_before_it_names():
    node = StandInNode()
    detector = StallDetector(node, timeout=0.2, loop=LOOPS['torque'])
    detector.note_silence(0.1, 0, 0)
    assert node.listeners
    assert not detector.named
