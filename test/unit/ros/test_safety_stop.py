"""A robot is stopped by request or far from the reference, and stays so until it is released."""

import math
import types

import pytest
from std_srvs.srv import Trigger

from mobile_robot_control.control.tracking_limit import allowed_distance
from mobile_robot_control.ros.safety_stop import SafetyStop


class Controller:
    """Stands for the node: has what is logged, and the services by name."""

    def __init__(self, lockstep=False):
        self.logged, self.services, self.acts = [], {}, 0
        self.again = ''
        self.stop = SafetyStop(self, lockstep, self.act)

    def get_logger(self):
        return types.SimpleNamespace(error=self.logged.append, info=self.logged.append)

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


def test_a_stop_holds_until_the_release():
    node = Controller()
    assert node.stop.reason == ''
    success, message = node.call('stop')
    assert success
    assert message == 'condition: by a call of stop; call release to drive on'
    assert node.call('stop') == (True, message)
    assert node.call('release') == (True, 'released: condition: ')
    assert node.call('release') == (True, 'released: condition: ')
    assert node.stop.reason == ''
    # each once
    assert node.logged == ['the robot is stopped: by a call of stop; call release to drive on', 'the robot is released']
    assert node.acts == 4


def test_beyond_the_limit_the_robot_is_stopped_with_value_limit_and_remedy():
    node = Controller()
    assert node.stop.allows(0.5, 0.5, approaching=False)
    assert not node.stop.allows(0.6249, 0.5, approaching=False)
    assert node.stop.reason.startswith('0.62 m from the reference, and limits.tracking_error is 0.5 m; ')
    assert 'raise the limit, then call release' in node.stop.reason
    assert len(node.logged) == 1
    # a stop by request does not hide the first reason
    assert '0.62 m from the reference' in node.call('stop')[1]
    assert node.call('release')[0]


def test_without_a_limit_no_distance_stops_it():
    assert Controller().stop.allows(1e9, 0.0, approaching=False)


def test_a_release_too_far_away_is_answered_with_the_new_stop():
    node = Controller()
    node.stop.allows(3.0, 1.0, approaching=False)
    node.again = True
    success, message = node.call('release')
    assert not success
    assert '3.00 m from the reference' in message


def test_an_approach_may_be_far_but_not_lead_away():
    node = Controller()
    for apart in (1.5, 1.6, 1.2, 0.7, 1.1):
        assert node.stop.allows(apart, 0.5, approaching=True), apart
    assert not node.stop.allows(1.3, 0.5, approaching=True)
    # a release begins it anew, from where the robot was carried
    node.call('release')
    assert node.stop.allows(1.3, 0.5, approaching=True)
    # one that tracks has no such allowance, and an approach after it begins anew
    assert node.stop.allows(0.4, 0.5, approaching=False)
    assert node.stop.allows(1.3, 0.5, approaching=True)


def test_in_lockstep_both_services_are_refused_with_what_to_do():
    node = Controller(lockstep=True)
    for name in ('stop', 'release'):
        success, message = node.call(name)
        assert not success
        assert 'paused' in message
    assert node.stop.reason == ''
    assert not node.acts


@pytest.mark.parametrize(('closest', 'limit', 'allowed'), [(0.0, 0.5, 0.5), (1.5, 0.5, 2.0), (1.5, 0.0, math.inf)])
def test_the_allowed_distance(closest, limit, allowed):
    assert allowed_distance(closest, limit) == allowed
