"""Odometry is published on /tf where tf2_ros is installed."""

import sys
import types

from mobile_robot_control.quantities import Pose
from mobile_robot_control.ros.nodes.plant_publishers import make_broadcaster


def test_without_tf2_there_is_no_broadcaster(monkeypatch):
    monkeypatch.setitem(sys.modules, 'tf2_ros', None)
    assert make_broadcaster(None, 'odom', 'base_link') is None


def test_with_tf2_odometry_becomes_a_transform(monkeypatch):
    sent = []
    module = types.ModuleType('tf2_ros')
    module.TransformBroadcaster = lambda node: types.SimpleNamespace(sendTransform=sent.append)
    monkeypatch.setitem(sys.modules, 'tf2_ros', module)
    make_broadcaster(None, 'odom', 'base_link')(1_500_000_000, Pose(1.0, -2.0, 0.0))
    transform, = sent
    assert (transform.header.frame_id, transform.child_frame_id) == ('odom', 'base_link')
    assert (transform.header.stamp.sec, transform.header.stamp.nanosec) == (1, 500_000_000)
    assert (transform.transform.translation.x, transform.transform.translation.y) == (1.0, -2.0)
    assert transform.transform.rotation.w == 1.0
