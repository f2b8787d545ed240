"""Bags of drawn robots whose numbers are hidden from who identifies them."""

import math

import numpy as np

from helpers.bag_making import CMD_VEL, GROUND_TRUTH, KINDS, ODOM, WALL
from helpers.stand_in_model import STEP, StandIn
from mobile_robot_control.excitation.excitation import Area, Excited, excite
from mobile_robot_control.model.base import Base, base_at_rest, base_step, discretise_base
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.runs.bag_writer import BagWriter

PERIOD = 5_000_000
"""Of the robot [ns]."""
COMMANDS, ODOMETRY = 4, 6
"""Periods from one message to the next."""
ROBOT = Robot()


def draw_base(random):
    """Draw a base, and the latency of its odometry [s]."""
    return Base(
        lag=tuple(random.uniform(0.03, 0.3, 2).tolist()), dead_time=(PERIOD / 1e9 * float(random.integers(0, 20)),) * 2,
        wheel_gain=tuple(random.uniform(0.97, 1.03, 2).tolist()), turn_gain=float(random.uniform(0.9, 1.05)),
    ), float(random.uniform(0.01, 0.06))


def commands(random, seconds, largest=(0.6, 2.0)):
    """Return commands that step between rest, full speed and anything else, shape (n, 2)."""
    count = round(seconds * 1e9 / PERIOD / COMMANDS)
    found, begin = np.zeros((count, 2)), 0
    while begin < count:
        end = begin + int(random.integers(30, 100))
        for n in (0, 1):
            found[begin:end, n] = largest[n] * random.choice([0.0, 1.0, -1.0, random.uniform(-1.0, 1.0),
                                                              random.uniform(-0.15, 0.15)])
        begin = end
    return found


def record(path, random, base, latency=0.04, seconds=40.0, asked=None, lost=0.05, jitter=0.005, ticks=509, offset=0.3,
           silent=(0.0, 0.0)):
    """
    Write the bag of a base: its odometry by encoders, late and not in order of its clock, and its true pose.

    Nothing is recorded between both times of `silent` [s].
    """
    asked = commands(random, seconds) if asked is None else asked
    made = discretise_base(base, ROBOT, PERIOD, COMMANDS * PERIOD, 0)
    state, base_state = at_rest(Pose(0.0, 0.0, 0.0)), base_at_rest(base, PERIOD, COMMANDS * PERIOD)
    tick = 2.0 * math.pi / ticks
    reckoned, counted, messages = Pose(0.0, 0.0, 0.0), (0.0, 0.0), []
    for k in range(COMMANDS * len(asked)):
        stamp = WALL + k * PERIOD
        command = BodyVelocity(*asked[k // COMMANDS].tolist())
        if k % COMMANDS == 0 and random.random() > lost:
            messages.append((stamp, 'cmd_vel', CMD_VEL(stamp, command)))
        if k % ODOMETRY == 0:
            angles = [tick * math.floor(angle / tick) for angle in (state.right_angle, state.left_angle)]
            right, left = (ROBOT.wheel_radius * (now - before) for now, before in zip(angles, counted, strict=True))
            counted = angles
            turn = (right - left) / ROBOT.wheel_separation
            reckoned = along_arc(reckoned, 0.5 * (right + left), turn)
            seen = stamp + round(1e9 * offset)
            if random.random() > lost:
                late = stamp + round(1e9 * (latency + jitter * random.random()))
                messages.append((late, 'odom', ODOM(seen, reckoned, state.velocity)))
            messages.append((stamp, 'ground_truth', GROUND_TRUTH(stamp, state.pose, state.velocity)))
        state, base_state = base_step(state, base_state, command, k, made)
    with BagWriter(path) as writer:
        for received, topic, message in sorted(messages):
            if silent[0] <= (received - WALL) / 1e9 < silent[1]:
                continue
            writer.write(f'/base/{topic}', KINDS[topic], received, message)
    return path


def record_stand_in(path, base, seconds=60.0, box=4.0, fastest=(0.8, 2.0), rate=50.0):
    """Write the bag of a stand-in base that is excited as the command `excite` does, with its pose from outside."""
    random = np.random.default_rng(0)
    robot, state, area = StandIn(base, (0.0, 0.0, 0.0)), Excited(), Area(box, box, BodyVelocity(*fastest))
    every, newest, messages = round(1.0 / rate / STEP), 0.0, []
    for k in range(round(seconds / STEP)):
        now = WALL + round(1e9 * k * STEP)
        robot.sample()
        stamp, pose, twist = robot.odometry[0]
        if stamp > newest:
            newest = stamp
            messages.append((now, 'odom', ODOM(WALL + round(1e9 * stamp), Pose(*pose), BodyVelocity(*twist))))
        if k % every == 0:
            seen = Pose(*(robot.pose + random.normal(0.0, 1e-3, 3)).tolist())
            messages.append((now, 'ground_truth', GROUND_TRUTH(now, seen, BodyVelocity(robot.v, robot.omega))))
            state, command = excite(state, k * STEP, Pose(*pose), BodyVelocity(*twist), area)
            robot.commanded = command
            messages.append((now, 'cmd_vel', CMD_VEL(now, command)))
        robot.move()
    with BagWriter(path) as writer:
        for received, topic, message in messages:
            writer.write(f'/base/{topic}', KINDS[topic], received, message)
    return path
