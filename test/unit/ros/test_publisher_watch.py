"""A node names a peer that DDS has discovered by half."""

import types

from mobile_robot_control.ros.services import publisher_watch
from mobile_robot_control.ros.services.publisher_watch import PublisherWatch
from mobile_robot_control.topics import LOOPS


class Graph:
    """Stands for a node: has the endpoints that it has discovered, by topic."""

    def __init__(self):
        self.publishers, self.subscriptions = {}, {}

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


def test_a_plant_that_publishes_and_does_not_listen_is_named_after_a_while(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(publisher_watch.time, 'monotonic', lambda: now[0])
    graph = Graph()
    watch = PublisherWatch(graph, [], LOOPS['torque'].listeners_of('velocity_controller'), 2.0)
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
