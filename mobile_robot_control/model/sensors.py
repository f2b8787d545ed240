"""The sensors of a robot that are not ideal: encoders and odometry at each step."""

from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.dynamics import PlantState, diverged
from mobile_robot_control.model.encoders import WheelAngles, angle_velocity, encoder_angles
from mobile_robot_control.model.events import events_until, is_event
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.noise import ODOMETRY_JITTER, jitter, measured_pose, measured_wheels
from mobile_robot_control.model.odometry import dead_reckoned, odometer_motion, wheel_slip
from mobile_robot_control.model.sensor_constants import SensorConstants, samples_on_their_way
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelVelocity


class OdometrySample(NamedTuple):
    """
    A sample of odometry.

    Attributes
    ----------
    k : int
        Step of the velocity loop at which the sample was taken.
    pose : Pose
        True or from dead reckoning, before the noise.
    velocity : BodyVelocity
        Of the measured wheels.
    """

    k: int
    pose: Pose
    velocity: BodyVelocity


class SensorState(NamedTuple):
    """
    The state of the sensors.

    Attributes
    ----------
    angles : tuple of WheelAngles
        Of the encoders, newest first: now and at each step of the window.
    reckoned : Pose
        Of dead reckoning.
    slipped : WheelAngles
        Of the encoders at the last update of the slip.
    samples : tuple of OdometrySample
        Newest first: those in transit, and the last that has arrived.
    """

    angles: tuple[WheelAngles, ...]
    reckoned: Pose
    slipped: WheelAngles
    samples: tuple[OdometrySample, ...]


def sensors_at_start(plant_state: PlantState, constants: SensorConstants) -> SensorState:
    """Return the sensors at a run's start: the first sample is taken there and shown from the start on."""
    angles = encoder_angles(plant_state.right_angle, plant_state.left_angle, constants.encoders)
    before = SensorState((angles,) * (constants.encoders.periods + 1), plant_state.pose, angles, ())
    sample = _sampled(before, plant_state, 0, constants)
    return before._replace(samples=(sample,) * (samples_on_their_way(constants.odometry) + 1))


@jitable
def seen_wheels(sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants) -> WheelVelocity:
    """
    Return the encoders' wheel velocities [rad/s] at step k, with noise.

    Parameters
    ----------
    sensors : SensorState
        At step k.
    plant_state : PlantState
        At step k.
    k : int
        Step of the velocity loop.
    constants : SensorConstants
        Encoders and noise.
    """
    if constants.encoders.differences:
        wheels = angle_velocity(sensors.angles[0], sensors.angles[-1], constants.encoders.window)
    else:
        wheels = wheel_velocity(plant_state.velocity, constants.robot)
    return measured_wheels(wheels, constants.noise, k)


@jitable
def seen_angles(sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants) -> WheelAngles:
    """Return the encoders' angles of the wheels [rad] at step k."""
    return sensors.angles[0]


@jitable
def _sampled(sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants) -> OdometrySample:
    """Take a sample of odometry at step k."""
    odometry = constants.odometry
    return OdometrySample(
        k,
        sensors.reckoned if odometry.dead_reckoning else plant_state.pose,
        odometer_motion(seen_wheels(sensors, plant_state, k, constants), odometry.calibration),
    )


@jitable
def advance_sensors(
    sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants
) -> SensorState:
    """
    Advance the sensors by one period, and sample odometry if a sample is due.

    Parameters
    ----------
    sensors : SensorState
        At step k - 1.
    plant_state : PlantState
        At step k.
    k : int
        Step of the velocity loop, at least 1.
    constants : SensorConstants
        Of the run.
    """
    # the run ends here, and the sine of infinity would raise; a finite position is no harm
    if diverged(plant_state, plant_state.pose):
        return sensors
    odometry = constants.odometry
    now = encoder_angles(plant_state.right_angle, plant_state.left_angle, constants.encoders)
    angles = (now, *sensors.angles)
    reckoned, slipped = sensors.reckoned, sensors.slipped
    if odometry.dead_reckoning:
        before = sensors.angles[0]
        right, left = now.right - before.right, now.left - before.left
        if odometry.slip > 0.0 and k % odometry.slip_periods == 0:
            turned = WheelAngles(now.right - slipped.right, now.left - slipped.left)
            slip = wheel_slip(turned, k, constants.noise.seed, odometry)
            right, left, slipped = right + slip.right, left + slip.left, now
        reckoned = dead_reckoned(reckoned, right, left, odometry.calibration)
    moved = SensorState(angles[:-1], reckoned, slipped, sensors.samples)
    if not is_event(k, odometry.events):
        return moved
    samples = (_sampled(moved, plant_state, k, constants), *sensors.samples)
    return SensorState(angles[:-1], reckoned, slipped, samples[:-1])


@jitable
def shown_sample(sensors: SensorState, k: int, constants: SensorConstants) -> OdometrySample:
    """Return the newest sample that has arrived at step k; its own step is the time of sampling."""
    odometry = constants.odometry
    age = events_until(k, odometry.events) - events_until(k - odometry.latency, odometry.events)
    if odometry.jitter > 0:
        while age < len(sensors.samples) - 1:
            sampled = sensors.samples[age].k
            late = odometry.latency + jitter(constants.noise.seed, ODOMETRY_JITTER, sampled, odometry.jitter)
            if sampled + late <= k:
                break
            age += 1
    return sensors.samples[age]


@jitable
def odometry_age(sensors: SensorState, k: int, constants: SensorConstants) -> int:
    """Return the age, in steps, of the odometry that is shown at step k."""
    return k - shown_sample(sensors, k, constants).k


@jitable
def seen_odometry(
    sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants
) -> tuple[Pose, BodyVelocity]:
    """Return pose and twist of odometry at step k, with the noise of the step at which they were sampled."""
    sample = shown_sample(sensors, k, constants)
    return measured_pose(sample.pose, constants.noise, sample.k), sample.velocity
