"""A robot that moves exactly as asked, and what its sensors show: for tests of the sensors."""

from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.dynamics import PlantState, at_rest, moved
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.model.odometry import Encoders, WheelAngles, WheelOdometry
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.model.sensors import (
    SensorState,
    advance_sensors,
    seen_angles,
    seen_odometry,
    seen_wheels,
    sensor_constants,
    sensors_at_start,
    shown_sample,
)
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelVelocity

# period of the velocity grid [ns] and [s], and such periods in a position period
PERIOD, DT, RATIO = 2_000_000, 0.002, 5
ROBOT, TRUE_ANGLES, TRUE_ODOMETRY, QUIET = Robot(), Encoders(), WheelOdometry(), Noise()


class Step(NamedTuple):
    """What is true after a step, and what is shown."""

    k: int
    plant: PlantState
    sensors: SensorState
    angles: WheelAngles
    wheels: WheelVelocity
    pose: Pose
    velocity: BodyVelocity
    taken: int


@jitable
def seen(k, plant, sensors, constants):
    """Return all that the sensors show."""
    pose, velocity = seen_odometry(sensors, plant, k, constants)
    return Step(
        k, plant, sensors, seen_angles(sensors, plant, k, constants), seen_wheels(sensors, plant, k, constants),
        pose, velocity, shown_sample(sensors, k, constants).k)


def begin(constants):
    """Return the robot at rest at the origin."""
    plant = at_rest(Pose(0.0, 0.0, 0.0))
    return seen(0, plant, sensors_at_start(plant, constants), constants)


@jitable
def go_on(step, velocity, constants, dt):
    """Move robot and sensors by one step, along the arc of a body velocity."""
    way, turn, pose = velocity.linear * dt, velocity.angular * dt, step.plant.pose
    end = along_arc(pose, way, turn)
    plant = moved(step.plant, end.x - pose.x, end.y - pose.y, way, turn, velocity, ROBOT)
    return seen(step.k + 1, plant, advance_sensors(step.sensors, plant, step.k + 1, constants), constants)


def drive(velocities, encoders=TRUE_ANGLES, odometry=TRUE_ODOMETRY, noise=QUIET, period=PERIOD):
    """Drive a robot from the origin by a body velocity in each step; return what is so after each of them."""
    constants = sensor_constants(ROBOT, noise, encoders, odometry, period, RATIO * period)
    step, run = begin(constants), []
    for velocity in velocities:
        step = go_on(step, velocity, constants, period / 1e9)
        run.append(step)
    return run


def shown_steps(odometry, period, steps):
    """Return the step of the sample that is shown at each step, from 0 on."""
    return [0, *(step.taken for step in drive([BodyVelocity(0.1, 0.0)] * (steps - 1), odometry=odometry,
                                              period=period))]
