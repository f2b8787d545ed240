"""Messages read into quantities; invalid ones are refused with a reason."""

import math
import struct
from types import SimpleNamespace as Message

import pytest

from mobile_robot_control.messages import parsing
from mobile_robot_control.messages.parsing import RefusedMessageError

RIGHT, LEFT = 'wheel_right_joint', 'wheel_left_joint'
FAULTS = [*((value, 'not finite') for value in (math.nan, math.inf, -math.inf)),
          *((value, 'too large') for value in (1e308, -1e308, 1.1e12))]
READERS = [(parsing.read_torque, 'effort'), (parsing.read_wheel_velocity, 'velocity'),
           (parsing.read_wheel_angles, 'position')]


def odometry(x=1.0, y=2.0, q=(0.0, 0.0, 0.0, 1.0), v=0.5, omega=-0.2, frames=('odom', 'base_link')):
    orientation = Message(x=q[0], y=q[1], z=q[2], w=q[3])
    twist = Message(linear=Message(x=v, y=9.0, z=9.0), angular=Message(x=9.0, y=9.0, z=omega))
    pose = Message(position=Message(x=x, y=y, z=9.0), orientation=orientation)
    return Message(header=Message(frame_id=frames[0]), child_frame_id=frames[1], pose=Message(pose=pose),
                   twist=Message(twist=twist))


def twist(v=0.5, omega=-0.2, frame='base_link'):
    return Message(header=Message(frame_id=frame), twist=Message(linear=Message(x=v), angular=Message(z=omega)))


def joints(names=(RIGHT, LEFT), position=(), velocity=(), effort=()):
    return Message(name=list(names), position=list(position), velocity=list(velocity), effort=list(effort))


def test_a_stamp_is_read_in_nanoseconds():
    assert parsing.serialised_stamp(b'\0\1\0\0' + struct.pack('<iI', 7, 9) + b'rest') == 7_000_000_009


@pytest.mark.parametrize('heading', [-3.0, -0.5 * math.pi, 0.0, 0.3, 3.1])
def test_odometry_gives_pose_and_body_velocity(heading):
    for sign in (1.0, -1.0):
        q = (0.0, 0.0, sign * math.sin(heading / 2.0), sign * math.cos(heading / 2.0))
        pose, velocity = parsing.read_odometry(odometry(q=q))
        assert pose == pytest.approx((1.0, 2.0, heading), abs=1e-14)
        assert velocity == (0.5, -0.2)


def test_odometry_of_a_tilted_robot_keeps_the_yaw():
    # pitched by 0.2 after a yaw of 1: z' y" rotations
    yaw, pitch = 0.5, 0.1
    q = (-math.sin(yaw) * math.sin(pitch), math.cos(yaw) * math.sin(pitch),
         math.sin(yaw) * math.cos(pitch), math.cos(yaw) * math.cos(pitch))
    assert parsing.read_odometry(odometry(q=q))[0].heading == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize(('value', 'fault'), FAULTS)
def test_numbers_that_are_not_finite_or_beyond_1e12_are_refused(value, fault):
    for names, what, make, read in ((('x', 'y', 'v', 'omega'), 'odometry', odometry, parsing.read_odometry),
                                    (('v', 'omega'), 'command', twist, parsing.read_twist)):
        for name in names:
            with pytest.raises(RefusedMessageError, match=f'{what} {fault}'):
                read(make(**{name: value}))
    for read, field in READERS:
        for names in ((RIGHT, LEFT), (LEFT, RIGHT)):
            with pytest.raises(RefusedMessageError, match=f'{field} {fault}'):
                read(joints(names, **{field: (1.0, value)}))
        # other joints are not checked
        assert read(joints(('arm', LEFT, RIGHT), **{field: (value, 1.0, 2.0)})) == (2.0, 1.0)


@pytest.mark.parametrize(('q', 'reason'), [
    ((0.0, 0.0, 0.0, 0.0), 'unit length'), ((0.0, 0.0, 0.0, 1.006), 'unit length'),
    ((0.5, 0.5, 0.5, 0.6), 'unit length'), ((0.0, 0.0, math.nan, 1.0), 'not finite'),
])
def test_odometry_with_an_invalid_quaternion_is_refused(q, reason):
    with pytest.raises(RefusedMessageError, match=reason):
        parsing.read_odometry(odometry(q=q))


@pytest.mark.parametrize(('frames', 'reason'), [
    (('map', 'base_link'), 'frame_id is not odom'), (('', 'base_link'), 'frame_id is not odom'),
    (('odom', 'camera'), 'child_frame_id is not base_link'),
])
def test_odometry_in_another_frame_is_refused(frames, reason):
    assert parsing.read_odometry(odometry(frames=frames))
    with pytest.raises(RefusedMessageError, match=reason) as refused:
        parsing.read_odometry(odometry(frames=frames), 'odom', 'base_link')
    assert refused.value.reason == reason
    assert next(frame for frame in frames if frame not in ('odom', 'base_link')) in refused.value.detail


def test_a_command_and_odometry_without_the_frame_of_the_robot_are_accepted():
    assert parsing.read_odometry(odometry(frames=('odom', '')), 'odom', 'base_link')
    assert parsing.read_twist(twist(frame=''), 'base_link') == (0.5, -0.2)
    assert parsing.read_twist(twist(frame='map')) == (0.5, -0.2)
    with pytest.raises(RefusedMessageError, match='frame_id is not base_link'):
        parsing.read_twist(twist(frame='map'), 'base_link')


@pytest.mark.parametrize(('read', 'field'), READERS)
def test_wheels_are_read_by_their_names(read, field):
    assert read(joints(**{field: (1.0, 2.0)})) == (1.0, 2.0)
    assert read(joints((LEFT, RIGHT), **{field: (1.0, 2.0)})) == (2.0, 1.0)
    for names, values, reason in (((RIGHT, LEFT), (), 'differ in number'), ((RIGHT, LEFT), (1.0,), 'differ in number'),
                                  ((RIGHT, LEFT), (1.0, 2.0, 3.0), 'differ in number'),
                                  ((RIGHT, 'arm'), (1.0, 2.0), 'a wheel is not named'),
                                  ((), (), 'a wheel is not named')):
        with pytest.raises(RefusedMessageError, match=reason):
            read(joints(names, **{field: values}))
