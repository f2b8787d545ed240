"""The guard of a robot whose base dies and comes back: it stops where odometry has begun anew."""

import types

import pytest

from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose, Reference
from mobile_robot_control.ros.position import robot_guard
from mobile_robot_control.ros.position.law_runner import LawRunner
from mobile_robot_control.ros.position.robot_guard import RobotGuard
from mobile_robot_control.settings.nodes import PositionControllerParameters

VALUES = PositionControllerParameters()
V, STILL, DT = BodyVelocity(0.3, 0.0), BodyVelocity(0.0, 0.0), 0.02
AT = Pose(1.2, 0.4, 1.5)
"""Where the base dies."""
RETURNS = {'at zero': Pose(0.0, 0.0, 0.0), 'there': AT, '5 cm away': AT._replace(x=AT.x + 0.05)}


@pytest.fixture(autouse=True)
def alone(monkeypatch):
    """No other node of the controller's name."""
    monkeypatch.setattr(robot_guard, 'Namesakes', lambda *_: types.SimpleNamespace(
        reason='', sending=str, note_sent=lambda _: None))


class Driving:
    """A guard on a drive that ends at AT; what it logs, and its events."""

    def __init__(self, in_conflict=False):
        self.logged, self.events = [], []
        log = types.SimpleNamespace(**dict.fromkeys(('error', 'warning', 'info'), self.logged.append))
        self.node = types.SimpleNamespace(
            get_logger=lambda: log, create_service=lambda *_: None,
            create_publisher=lambda *_: types.SimpleNamespace(publish=lambda _: None),
            context=types.SimpleNamespace(get_domain_id=lambda: -1), get_fully_qualified_name=lambda: '/without_ros')
        self.conflict = types.SimpleNamespace(present=False, note=lambda *_: None, begin=lambda *_: None)
        law = LawRunner(self.node, VALUES.control, DT, lambda: None)
        self.guard = RobotGuard(self.node, law, lambda: self.conflict, str, self.events.append, 'no kind')
        self.time, self.in_conflict = 100.0, in_conflict

    def note(self, pose, velocity, drives):
        self.guard.note(round(self.time * 1e9), pose, velocity, VALUES, drives)

    def command(self, cart):
        error = tracking_error(AT, AT)
        self.guard.command(Observation(error, Reference(AT, cart), STILL), 0, VALUES)

    def drive(self, cart=V):
        """Drive up to AT beside a cart, and on without odometry until it is too old."""
        for n in range(50, -1, -1):
            self.note(AT._replace(y=AT.y - n * DT * cart.linear), cart, n < 50)
            self.command(cart)
            self.time += DT
        for _ in range(25):
            self.command(cart)

    def dies(self, silence, pose):
        """Come back after a silence [s]; return the reason of a stop."""
        self.time += silence
        self.conflict.present = self.in_conflict
        for _ in range(10):
            self.note(pose, STILL, silence < VALUES.input_timeout)
            self.time += DT
        return self.reason()

    def reason(self):
        found = self.guard.condition(VALUES._replace(stop_on_odom_conflict=False), [], drives=True)
        return found.detail if found else ''


@pytest.mark.parametrize('in_conflict', [False, True])
@pytest.mark.parametrize('silence', [0.2, 2.0, 20.0])
def test_a_base_that_dies_stops_the_robot_if_odometry_begins_anew_and_drives_on_if_it_does_not(silence, in_conflict):
    for where, pose in RETURNS.items():
        driving = Driving(in_conflict)
        driving.drive()
        reason = driving.dies(silence, pose)
        assert bool(reason) == (where == 'at zero'), where
        if reason:
            assert 'the pose of odom has jumped by 1.26 m and 1.50 rad across a silence of ' in reason


def test_odometry_that_begins_anew_beside_a_standing_cart_or_before_a_drive_stops_nothing():
    for drives in (True, False):
        driving = Driving()
        if drives:
            driving.drive(STILL)
        else:
            driving.note(AT, STILL, drives=False)
        assert driving.dies(2.0, RETURNS['at zero']) == ''
        assert {'odom_jump'} == {key for event in driving.events for key in event}


def test_a_jump_during_a_stop_joins_its_reason():
    driving = Driving()
    driving.drive()
    driving.dies(2.0, RETURNS['at zero'])
    first = driving.reason()
    for n in range(5):
        driving.dies(3.0 + n, (AT, RETURNS['at zero'])[n % 2])
    assert driving.reason().startswith(f'{first}; and the pose of odom has jumped')
    assert driving.reason().count('; and ') == 2
    assert [event for event in driving.events if 'stop' in event] == [{'stop': first}]
