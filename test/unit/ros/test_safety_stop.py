"""A robot is stopped by request or far from the reference, and stays so until it is released."""

import math
import types
from collections import Counter

import pytest
from each import each_row
from std_msgs.msg import String
from std_srvs.srv import Trigger

from mobile_robot_control.control.tracking_limit import allowed_distance
from mobile_robot_control.messages.serialising import serialise
from mobile_robot_control.ros.clocks.safety_stop import SafetyStop, refuse_to_stop
from mobile_robot_control.ros.clocks.stop_memory import remember_stops
from mobile_robot_control.ros.inputs.input_validation import InputValidator

BY_CALL = 'by a call of stop; call release to drive on'


class Endpoints:
    """Stands for a node: has what is published and who takes what, by topic, and what is logged."""

    def __init__(self):
        self.published, self.takes, self.logged, self.peers = {}, {}, [], 0
        self.validator = InputValidator(self, types.SimpleNamespace(note_input=None), 1.0)

    def get_logger(self):
        return types.SimpleNamespace(error=self.logged.append, info=self.logged.append, warning=self.logged.append)

    def create_publisher(self, kind, topic, _quality):
        assert kind is String
        sent = self.published[topic] = []
        return types.SimpleNamespace(publish=lambda message: sent.append(message.data))

    def create_subscription(self, kind, topic, take, _quality, raw):
        assert (kind, raw) == (String, True)
        self.takes[topic] = lambda reason: take(
            reason if isinstance(reason, bytes) else bytes(serialise(String(data=reason))))

    def resolve_topic_name(self, topic):
        return topic

    def count_publishers(self, _topic):
        return self.peers


class Controller(Endpoints):
    """Stands for the position controller: has its services by name, and perhaps a cart."""

    def __init__(self, peers=0):
        super().__init__()
        self.services, self.acts, self.noted, self.peers = {}, 0, [], peers
        self.again = ''
        self.stop = SafetyStop(self, self.validator, self.act, self.noted.append)

    def create_service(self, kind, name, answer):
        assert kind is Trigger
        self.services[name] = answer

    def act(self):
        self.acts += 1
        if self.again:
            self.stop.allows(3.0, 1.0, approaching=False)
        return f'condition: {self.stop.reason}'

    def call(self, name):
        response = self.services[f'~/{name}'](Trigger.Request(), Trigger.Response())
        return response.success, response.message


@pytest.fixture
def node():
    return Controller()


def test_a_stop_holds_until_the_release(node):
    assert node.stop.reason == ''
    assert [node.call('stop') for _ in range(2)] == [(True, f'condition: {BY_CALL}')] * 2
    assert [node.call('release') for _ in range(2)] == [(True, 'released: condition: ')] * 2
    assert node.stop.reason == ''
    # each once
    assert node.logged == [f'the robot is stopped: {BY_CALL}', 'the robot is released']
    assert node.noted == [BY_CALL, '']
    assert node.acts == 4


def test_beyond_the_limit_the_robot_is_stopped_with_value_limit_and_remedy(node):
    assert node.stop.allows(1e9, 0.0, approaching=False)  # no limit
    assert node.stop.allows(0.5, 0.5, approaching=False)
    assert not node.stop.allows(0.6249, 0.5, approaching=False)
    assert node.stop.reason.startswith('0.62 m from the reference, and limits.tracking_error is 0.5 m; ')
    assert 'raise the limit, then call release' in node.stop.reason
    assert len(node.logged) == 1
    # a stop by request does not hide the first reason
    assert '0.62 m from the reference' in node.call('stop')[1]
    # a release too far away is answered with the new stop
    node.again = True
    success, message = node.call('release')
    assert not success
    assert '3.00 m from the reference' in message


def test_an_approach_may_be_far_but_not_lead_away(node):
    for apart in (1.5, 1.6, 1.2, 0.7, 1.1):
        assert node.stop.allows(apart, 0.5, approaching=True), apart
    assert not node.stop.allows(1.3, 0.5, approaching=True)
    # a release begins it anew, from where the robot was carried
    node.call('release')
    assert node.stop.allows(1.3, 0.5, approaching=True)
    # one that tracks has no such allowance, and an approach after it begins anew
    assert node.stop.allows(0.4, 0.5, approaching=False)
    assert node.stop.allows(1.3, 0.5, approaching=True)


@each_row(('closest', 'limit', 'allowed'), [(0.0, 0.5, 0.5), (1.5, 0.5, 2.0), (1.5, 0.0, math.inf)])
def test_the_allowed_distance(closest, limit, allowed):
    assert allowed_distance(closest, limit) == allowed


def test_in_lockstep_both_services_are_refused_with_what_to_do(node):
    refuse_to_stop(node)
    for name in ('stop', 'release'):
        success, message = node.call(name)
        assert not success
        assert 'paused' in message
    assert (node.stop.reason, node.acts) == ('', 0)


def test_a_controller_that_finds_a_cart_waits_for_its_memory_and_takes_over_the_stop():
    node = Controller(peers=1)
    # what cannot be read is counted, and the robot stands
    node.takes['stop_memory'](b'\0\1\0\0\xff\0\0\0a')
    assert node.validator.refused == Counter({'stop_memory: not readable': 1})
    assert not node.stop.is_known()
    node.takes['stop_memory'](BY_CALL)
    assert node.stop.is_known()
    assert node.stop.reason == BY_CALL
    # a cart that is started again learns it from here, and a later memory changes nothing
    assert node.published['stopped'] == [BY_CALL]
    node.takes['stop_memory']('')
    assert node.stop.reason
    assert node.call('release')[0]
    assert node.published['stopped'][1:] == ['']
    node.takes['stop_memory']('of long ago')
    assert not node.stop.reason


def test_without_a_stop_or_without_a_cart_of_ours_a_controller_may_drive_and_a_call_before_the_memory_counts(node):
    remembered, called = Controller(peers=1), Controller(peers=1)
    remembered.takes['stop_memory']('')
    assert remembered.stop.is_known()
    assert node.stop.is_known()
    # what it does not know, a new cart must not forget
    assert not remembered.logged + node.logged + remembered.published['stopped'] + node.published['stopped']
    assert called.call('release')[0]
    called.takes['stop_memory']('of the process before')
    assert not called.stop.reason


def test_the_cart_publishes_what_it_was_told_and_at_first_that_there_is_no_stop():
    cart = Endpoints()
    remember_stops(cart, cart.validator)
    cart.takes['stopped']('by a call of stop')
    cart.takes['stopped']('')
    assert cart.published['stop_memory'] == ['', 'by a call of stop', '']
