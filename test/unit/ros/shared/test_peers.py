"""The node that a run waits for is named: one that DDS has discovered by half, or that does not answer for long."""

import types

from mobile_robot_control.ros.shared import peers
from mobile_robot_control.ros.shared.peers import PublisherWatch, StallDetector
from mobile_robot_control.topics import LOOP_TOPICS, LOOPS


class Graph:
    """Stands for a node: has the endpoints that it has discovered, by topic, its subscriptions and warnings."""

    def __init__(self):
        self.publishers, self.subscriptions, self.listeners, self.warnings = {}, {}, {}, []

    resolve_topic_name = staticmethod(lambda topic: f'/{topic}')

    def count_publishers(self, topic):
        return len(self.publishers.get(topic, ()))

    @staticmethod
    def _endpoints(processes):
        # 12 bytes name the process, the others the endpoint
        return [types.SimpleNamespace(endpoint_gid=[process] * 12 + [n] * 4) for n, process in enumerate(processes)]

    def get_publishers_info_by_topic(self, topic):
        return self._endpoints(self.publishers.get(topic, ()))

    def get_subscriptions_info_by_topic(self, topic):
        return self._endpoints(self.subscriptions.get(topic, ()))

    def create_subscription(self, kind, topic, callback, qos, raw):
        self.listeners[topic] = callback
        return topic

    def get_logger(self):
        return types.SimpleNamespace(warning=self.warnings.append, info=self.warnings.append)


def test_a_plant_that_publishes_and_does_not_listen_is_named_after_a_while(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(peers.time, 'monotonic', lambda: now[0])
    graph = Graph()
    watch = PublisherWatch(graph, {}, LOOPS['torque'].listeners_of('velocity_controller'), 2.0)
    watch.look()
    assert not watch.problems()
    # process 1 is the plant; process 2, a recorder, listens
    graph.publishers = {'/joint_states': [1], '/odom': [1]}
    graph.subscriptions = {'/wheel_torques': [2]}
    for now[0] in (1.0, 2.0, 3.0):
        watch.look()
        assert not watch.problems()
    now[0] = 3.5
    assert watch.problems() == [
        'plant is discovered, but not as a listener of wheel_torques: start this node again']
    graph.subscriptions['/wheel_torques'].append(1)
    watch.look()
    assert not watch.problems()


def test_what_the_listeners_of_a_node_publish():
    assert LOOPS['torque'].listeners_of('plant') == {
        'joint_states': {'velocity_controller': ['wheel_torques']},
        'odom': {'position_controller': ['cmd_vel', 'tracking_error'], 'reference_cart': ['reference']}}
    assert LOOPS['velocity'].listeners_of('position_controller') == {'cmd_vel': {'plant': ['joint_states', 'odom']}}


def test_only_a_long_stall_adds_subscriptions_and_names_its_node():
    node = Graph()
    node.publishers = {topic: [1] for topic in LOOP_TOPICS}
    detector = StallDetector(node, timeout=2.0, loop=LOOPS['torque'])
    for silence in (0.1, 0.2, 0.4):
        detector.note_silence(silence, 0, 0)
        assert not node.listeners
    for silence in (0.5, 1.9):
        detector.note_silence(silence, 0, 0)
        assert set(node.listeners) == {'reference', 'cmd_vel'}
        assert not node.warnings
    detector.note_silence(2.6, 0, 0)
    assert detector.named == ['reference_cart']
    assert 'waiting for reference_cart' in node.warnings[0]
    detector.note_progress()
    # a subscription that goes may leave DDS unable to discover the plant again
    assert set(node.listeners) == {'reference', 'cmd_vel'}
    assert 'answered' in node.warnings[1]
    # with a short timeout it subscribes before it names
    node.listeners.clear()
    detector = StallDetector(node, timeout=0.2, loop=LOOPS['torque'])
    detector.note_silence(0.1, 0, 0)
    assert node.listeners
    assert not detector.named
