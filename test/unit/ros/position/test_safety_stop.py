"""A robot is stopped by request or far from the reference, and stays so until it is released."""

import math
import types

import pytest
from std_msgs.msg import String
from std_srvs.srv import Trigger

from mobile_robot_control.control.limits import allowed_distance
from mobile_robot_control.ros.position.safety_stop import SafetyStop, refuse_to_stop

BY_CALL = 'by a call of stop; call release to drive on'


class Controller:
    """Stands for the position controller: has its services by name, and what is published and logged."""

    def __init__(self, domain=7, name='/position_controller'):
        self.published, self.logged, self.services, self.acts, self.noted = [], [], {}, 0, []
        self.others, self.reason = '', ''
        self.again = ''
        self.context = types.SimpleNamespace(get_domain_id=lambda: domain)
        self.get_fully_qualified_name = lambda: name
        self.stop = SafetyStop(self, self.act, self.noted.append, self)

    def sending(self):
        return self.others

    def get_logger(self):
        return types.SimpleNamespace(error=self.logged.append, info=self.logged.append)

    def create_publisher(self, kind, topic, _quality):
        assert (kind, topic) == (String, 'stopped')
        return types.SimpleNamespace(publish=lambda message: self.published.append(message.data))

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
def node(tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
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


@pytest.mark.parametrize(('closest', 'limit', 'allowed'), [(0.0, 0.5, 0.5), (1.5, 0.5, 2.0), (1.5, 0.0, math.inf)])
def test_the_allowed_distance(closest, limit, allowed):
    assert allowed_distance(closest, limit) == allowed


def test_in_lockstep_both_services_are_refused_with_what_to_do(node):
    refuse_to_stop(node)
    for name in ('stop', 'release'):
        success, message = node.call(name)
        assert not success
        assert 'paused' in message
    assert (node.stop.reason, node.acts) == ('', 0)


def test_a_stop_outlives_the_node_that_made_it_until_its_release(node):
    node.stop.allows(0.6249, 0.5, approaching=False)
    assert node.stop.remember() == ''
    for again in (Controller(), Controller()):
        assert again.stop.reason == node.stop.reason
        assert again.noted == [node.stop.reason]
        assert again.published == [node.stop.reason]
        assert again.logged == [f'the robot is stopped: {node.stop.reason}']
    # others have their own
    assert {Controller(domain=8).stop.reason, Controller(name='/robot1/position_controller').stop.reason} == {''}
    assert again.call('release')[0]
    assert Controller().stop.reason == ''


def test_a_stop_is_kept_before_it_is_answered_and_after_the_robot_was_told(node):
    kept = []
    node.stop._act = lambda: kept.append(node.stop.reason and Controller().stop.reason) or 'stopped'
    assert node.call('stop') == (True, 'stopped')
    assert kept == ['']
    assert Controller().stop.reason == BY_CALL


@pytest.mark.parametrize('hinder', [
    lambda folder: (folder / 'mobile_robot_control').write_text('a file where the folder would be'),
    lambda folder: (folder / 'mobile_robot_control/stops/7/position_controller.txt').mkdir(parents=True)])
def test_a_stop_that_cannot_be_kept_stops_all_the_same_and_says_so(hinder, tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    hinder(tmp_path)
    node = Controller()
    node.call('release')
    success, message = node.call('stop')
    assert success
    assert node.stop.reason == BY_CALL
    assert f'the stop does not outlive this node: {tmp_path}' in message
    assert any(str(tmp_path) in line for line in node.logged)


def test_what_is_there_and_cannot_be_read_is_a_stop(node):
    node.call('stop')
    for spoil in (lambda file: file.write_bytes(b''), lambda file: file.write_bytes(b'\xff' * 9),
                  lambda file: file.write_bytes(bytes(1 << 17)), lambda file: (file.unlink(), file.mkdir())):
        spoil(node.stop._memory.file)
        assert Controller().stop.reason


def test_no_release_acts_while_another_node_of_the_name_sends(tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    node = Controller()
    node.call('stop')
    node.others = '2 nodes named /position_controller send cmd_vel'
    assert node.call('release') == (False, node.others)
    assert node.stop.reason
    node.others = ''
    assert node.call('release')[0]
    assert not node.stop.reason
