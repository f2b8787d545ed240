"""Prediction of periods without events: no wheel stops or breaks away, and no motor reaches its line."""

from mobile_robot_control.jit import jitable
from mobile_robot_control.model import coupled
from mobile_robot_control.model.drivetrain import Drivetrain
from mobile_robot_control.model.dynamics import PlantState, mean_velocity, moved, step
from mobile_robot_control.model.friction import sign
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.model.wheels import Forcing
from mobile_robot_control.quantities import BodyVelocity, WheelTorque, WheelVelocity


@jitable
def coriolis_torque(speed: WheelVelocity, robot: Robot) -> WheelTorque:
    """Return the Coriolis pair that Eq. (13)-(14) lack, as torques on the wheels [N m]."""
    r, R = robot.wheel_radius, half_separation(robot)
    pair = 0.5 * r * r / R * robot.mass * robot.com_offset * 0.5 * r * (speed.right - speed.left) / R
    return WheelTorque(-pair * speed.left, pair * speed.right)


@jitable
def _reach(speed: WheelVelocity, fading: WheelTorque, forcing: Forcing, drivetrain: Drivetrain) -> float:
    """Return a bound [rad/s] of the change of each wheel's speed over a period in which each keeps its direction."""
    axle, coulomb = drivetrain.axle, drivetrain.axle.coulomb
    K = axle.viscous_friction
    right = forcing.asked.right + fading.right + forcing.outside.right - coulomb * sign(speed.right) - K * speed.right
    left = forcing.asked.left + fading.left + forcing.outside.left - coulomb * sign(speed.left) - K * speed.left
    linear = abs(right + left) + abs(fading.right + fading.left)
    angular = abs(right - left) + abs(fading.right - fading.left)
    if drivetrain.plant.centripetal_coupling:
        # twice the pair's present size: it changes little within a period, and only where no bound is left behind
        pair = coriolis_torque(speed, drivetrain.plant.robot)
        linear += 2.0 * (abs(pair.right) + abs(pair.left))
        angular += 2.0 * (abs(pair.right) + abs(pair.left))
    return 0.5 * drivetrain.plant.dt * (linear / axle.linear_inertia + angular / axle.angular_inertia)


@jitable
def _within_line(speed: float, reach: float, asked: float, fading: float, drivetrain: Drivetrain) -> bool:
    """Return whether a motor stays within its torque-speed line over a period."""
    highest, lowest = asked + max(fading, 0.0), asked + min(fading, 0.0)
    stall, slope = drivetrain.axle.stall_torque, drivetrain.axle.slope
    return slope * (speed + reach) + highest <= stall and slope * (speed - reach) + lowest >= -stall


@jitable
def stands(speed: float, asked: float, fading: float, outside: float, coulomb: float) -> bool:
    """Return whether a wheel stands over a whole period, beside another that stands."""
    torque = asked + outside
    return speed == 0.0 and abs(torque) <= coulomb and abs(torque + fading) <= coulomb


@jitable
def is_uneventful(speed: WheelVelocity, fading: WheelTorque, forcing: Forcing, drivetrain: Drivetrain) -> bool:
    """Return whether a period is certainly without an event; False does not imply an event."""
    reach = _reach(speed, fading, forcing, drivetrain)
    turning = drivetrain.axle.coulomb == 0.0 or (abs(speed.right) > reach and abs(speed.left) > reach)
    return turning and (
        drivetrain.axle.slope == 0.0
        or (_within_line(speed.right, reach, forcing.asked.right, fading.right, drivetrain)
            and _within_line(speed.left, reach, forcing.asked.left, fading.left, drivetrain)))


@jitable
def uneventful_step(state: PlantState, fading: WheelTorque, torque: WheelTorque, drivetrain: Drivetrain) -> PlantState:
    """Move the plant by one period without an event, under held and fading torques on the wheels [N m]."""
    plant = drivetrain.plant
    if drivetrain.axle.lag_rate == 0.0:
        return step(state, torque, plant)
    robot = plant.robot
    if plant.centripetal_coupling:
        motion = coupled.advance_fading(
            state.pose, state.velocity, torque, fading, drivetrain.axle.lag_rate, robot, plant.dt)
        return moved(state, motion.x, motion.y, motion.distance, motion.turn,
                     BodyVelocity(motion.linear, motion.angular), robot)
    v, omega = state.velocity
    along, around = 0.5 * robot.wheel_radius, 0.5 * robot.wheel_radius / half_separation(robot)
    push = along * (torque.right + torque.left) / drivetrain.axle.linear_inertia
    twist = around * (torque.right - torque.left) / drivetrain.axle.angular_inertia
    fading_push = along * (fading.right + fading.left) / drivetrain.axle.linear_inertia
    fading_twist = around * (fading.right - fading.left) / drivetrain.axle.angular_inertia
    linear, angular = drivetrain.linear, drivetrain.angular
    a, b, c, end = plant.linear
    speeds = (a.decay * v + a.gain * push + linear.first.gain * fading_push,
              b.decay * v + b.gain * push + linear.middle.gain * fading_push,
              c.decay * v + c.gain * push + linear.last.gain * fading_push)
    speed = end.decay * v + end.gain * push + linear.end.gain * fading_push
    distance = end.gain * v + end.travel * push + linear.end.travel * fading_push
    a, b, c, end = plant.angular
    heading = state.pose.heading
    x, y = mean_velocity(speeds, (
        heading + (a.gain * omega + a.travel * twist + angular.first.travel * fading_twist),
        heading + (b.gain * omega + b.travel * twist + angular.middle.travel * fading_twist),
        heading + (c.gain * omega + c.travel * twist + angular.last.travel * fading_twist),
    ))
    turn = end.gain * omega + end.travel * twist + angular.end.travel * fading_twist
    yaw_rate = end.decay * omega + end.gain * twist + angular.end.gain * fading_twist
    return moved(state, plant.dt * x, plant.dt * y, distance, turn, BodyVelocity(speed, yaw_rate), robot)
