"""The plant with motors and friction: from the torques asked for to motion over one sampling period."""

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.jit import jitable, jitable_apart
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.disturbance import disturbed
from mobile_robot_control.model.drivetrain import Drivetrain
from mobile_robot_control.model.dynamics import PlantState, mean_velocity, moved, step
from mobile_robot_control.model.friction import sign
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.motors import DelayLine, MotorState, delayed, saturate
from mobile_robot_control.model.plant import Imperfections
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.model.stick_slip import MOST_EVENTS, advance_wheels, engaged
from mobile_robot_control.model.wheels import Forcing, Rolling, Wheel
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity


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
    right = forcing.request.right + fading.right + forcing.outside.right - coulomb * sign(speed.right) - K * speed.right
    left = forcing.request.left + fading.left + forcing.outside.left - coulomb * sign(speed.left) - K * speed.left
    linear = abs(right + left) + abs(fading.right + fading.left)
    angular = abs(right - left) + abs(fading.right - fading.left)
    if drivetrain.plant.centripetal_coupling:
        # twice the pair's present size: it changes little within a period, and only where no bound is left behind
        pair = coriolis_torque(speed, drivetrain.plant.robot)
        linear += 2.0 * (abs(pair.right) + abs(pair.left))
        angular += 2.0 * (abs(pair.right) + abs(pair.left))
    return 0.5 * drivetrain.plant.dt * (linear / axle.linear_inertia + angular / axle.angular_inertia)


@jitable
def _within_line(speed: float, reach: float, request: float, fading: float, drivetrain: Drivetrain) -> bool:
    """Return whether a motor stays within its torque-speed line over a period."""
    highest, lowest = request + max(fading, 0.0), request + min(fading, 0.0)
    stall, slope = drivetrain.axle.stall_torque, drivetrain.axle.slope
    return slope * (speed + reach) + highest <= stall and slope * (speed - reach) + lowest >= -stall


@jitable
def stands(speed: float, request: float, fading: float, outside: float, coulomb: float) -> bool:
    """Return whether a wheel stands over a whole period, beside another that stands."""
    torque = request + outside
    return speed == 0.0 and abs(torque) <= coulomb and abs(torque + fading) <= coulomb


@jitable
def is_uneventful(speed: WheelVelocity, fading: WheelTorque, forcing: Forcing, drivetrain: Drivetrain) -> bool:
    """Return whether a period is certainly without an event; False does not imply an event."""
    reach = _reach(speed, fading, forcing, drivetrain)
    turning = drivetrain.axle.coulomb == 0.0 or (abs(speed.right) > reach and abs(speed.left) > reach)
    return turning and (
        drivetrain.axle.slope == 0.0
        or (_within_line(speed.right, reach, forcing.request.right, fading.right, drivetrain)
            and _within_line(speed.left, reach, forcing.request.left, fading.left, drivetrain)))


@jitable
def uneventful_step(state: PlantState, fading: WheelTorque, torque: WheelTorque, drivetrain: Drivetrain) -> PlantState:
    """Move the plant by one period without an event, under held and fading torques on the wheels [N m]."""
    plant = drivetrain.plant
    if drivetrain.axle.lag_rate == 0.0:
        return step(state, torque, plant)
    robot = plant.robot
    if plant.centripetal_coupling:
        motion = dynamics.advance_fading(
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


@jitable_apart
def _body_velocity(speed: WheelVelocity, robot: Robot) -> BodyVelocity:
    """Return the body velocity from which `wheel_velocity` computes exactly 0.0 again for a standing wheel."""
    rim = 0.5 * robot.wheel_radius / half_separation(robot)
    if speed.right == 0.0 and speed.left == 0.0:
        return BodyVelocity(0.0, 0.0)
    if speed.right == 0.0:
        yaw_rate = -rim * speed.left
        return BodyVelocity(-half_separation(robot) * yaw_rate, yaw_rate)
    if speed.left == 0.0:
        yaw_rate = rim * speed.right
        return BodyVelocity(half_separation(robot) * yaw_rate, yaw_rate)
    return body_velocity(speed, robot)


@jitable_apart
def _coupled_advance(rolling: Rolling, forcing: Forcing, drivetrain: Drivetrain, most_events: int) -> Rolling:
    """Return both wheels after a period; the Coriolis pair is held over short substeps at its value in the middle."""
    robot, axle, outside = drivetrain.plant.robot, drivetrain.axle, forcing.outside
    count = dynamics.substeps(drivetrain.plant.dt)
    h = drivetrain.plant.dt / count
    for _ in range(count):
        middle = rolling
        for share in (0.5, 1.0):
            pair = coriolis_torque(WheelVelocity(middle.right.speed, middle.left.speed), robot)
            held = Forcing(forcing.request, WheelTorque(outside.right + pair.right, outside.left + pair.left),
                           forcing.heading)
            middle = advance_wheels(engaged(rolling, held, axle), held, share * h, axle, most_events)
        rolling = middle
    return rolling


@jitable_apart
def eventful_step(
    state: PlantState, fading: WheelTorque, forcing: Forcing, drivetrain: Drivetrain, most_events: int
) -> tuple[PlantState, WheelTorque]:
    """
    Move the plant by one period, with all events within it.

    Parameters
    ----------
    state : PlantState
        At the period's start.
    fading : WheelTorque
        Lagging torques minus those asked for [N m].
    forcing : Forcing
        Torques held over the period.
    drivetrain : Drivetrain
        Constants.
    most_events : int
        After so many events the wheels are held still.

    Returns
    -------
    tuple of PlantState and WheelTorque
        State at the period's end, and the mean torque of the motors [N m].
    """
    robot, dt = drivetrain.plant.robot, drivetrain.plant.dt
    speed = wheel_velocity(state.velocity, robot)
    rolling = Rolling(0.0, 0.0, Wheel(speed.right, 0.0, fading.right, 0.0, 0.0, 0.0),
                      Wheel(speed.left, 0.0, fading.left, 0.0, 0.0, 0.0))
    if drivetrain.plant.centripetal_coupling:
        end = _coupled_advance(rolling, forcing, drivetrain, most_events)
    else:
        end = advance_wheels(engaged(rolling, forcing, drivetrain.axle), forcing, dt, drivetrain.axle, most_events)
    turn = 0.5 * robot.wheel_radius * (end.right.angle - end.left.angle) / half_separation(robot)
    return PlantState(
        Pose(state.pose.x + end.x, state.pose.y + end.y, wrap_angle(state.pose.heading + turn)),
        _body_velocity(WheelVelocity(end.right.speed, end.left.speed), robot),
        state.right_angle + end.right.angle,
        state.left_angle + end.left.angle,
    ), WheelTorque(forcing.request.right - end.right.lacking / dt, forcing.request.left - end.left.lacking / dt)


@jitable
def motorised_step(
    state: PlantState, motors: MotorState, request: WheelTorque, outside: WheelTorque, drivetrain: Drivetrain
) -> tuple[PlantState, MotorState, WheelTorque]:
    """
    Move the plant by one period with its motors and friction.

    Solves Eq. (13)-(14) of the chapter with a torque-speed line, a lag and Coulomb friction at each wheel: speeds,
    heading, wheel angles and the times of all events to rounding errors; the position by a quadrature of sixth order.

    Parameters
    ----------
    state : PlantState
        At the period's start. A standing wheel has the speed 0.0 exactly.
    motors : MotorState
        Torques reached by the lag.
    request : WheelTorque
        Torques asked of the motors [N m], held; within their stall torque.
    outside : WheelTorque
        Torques on the wheels that do not come through the motors [N m], held.
    drivetrain : Drivetrain
        From `discretise_drivetrain`.

    Returns
    -------
    tuple of PlantState, MotorState and WheelTorque
        State and motors at the period's end, and the mean over the period of the torque at the motors' shafts, behind
        the torque-speed line and the lag and before any friction [N m].

    Notes
    -----
    With ``centripetal_coupling`` speeds have no closed form. A period that is certainly without an event uses the
    Runge-Kutta method of `coupled`. In any other period the Coriolis pair is held, at its value in the middle, over
    substeps of at most 0.25 ms. The error is below 2e-6 rad/s a period for the chapter's robot, and up to 1e-5 rad/s
    for a robot of 100 g.

    """
    coulomb = drivetrain.axle.coulomb
    if drivetrain.axle.lag_rate > 0.0:
        fading = WheelTorque(motors.torque.right - request.right, motors.torque.left - request.left)
    else:
        fading = WheelTorque(0.0, 0.0)
    after = MotorState(WheelTorque(request.right + drivetrain.remainder * fading.right,
                                   request.left + drivetrain.remainder * fading.left))
    mean = WheelTorque(request.right + drivetrain.mean_remainder * fading.right,
                       request.left + drivetrain.mean_remainder * fading.left)
    speed = wheel_velocity(state.velocity, drivetrain.plant.robot)
    if (stands(speed.right, request.right, fading.right, outside.right, coulomb)
            and stands(speed.left, request.left, fading.left, outside.left, coulomb)):
        return state, after, mean
    forcing = Forcing(request, outside, state.pose.heading)
    if drivetrain.predictable and is_uneventful(speed, fading, forcing, drivetrain):
        torque = WheelTorque(request.right + outside.right - coulomb * sign(speed.right),
                             request.left + outside.left - coulomb * sign(speed.left))
        return uneventful_step(state, fading, torque, drivetrain), after, mean
    moved, mean = eventful_step(state, fading, forcing, drivetrain, MOST_EVENTS)
    return moved, after, mean


@jitable
def driven_step(
    state: PlantState, motors: MotorState, line: DelayLine, torque: WheelTorque, k: int, drivetrain: Drivetrain,
    imperfect: Imperfections, motor_limit: float,
) -> tuple[PlantState, MotorState, DelayLine, WheelTorque, WheelTorque]:
    """
    Move the plant by one period, with delayed and limited torques, motors, friction and a disturbance.

    Replaces `plant.actuated_step` if motors or friction are not ideal.

    Parameters
    ----------
    state : PlantState
        At the period's start.
    motors : MotorState
        At the period's start.
    line : DelayLine
        Torques asked for before.
    torque : WheelTorque
        Asked for now [N m].
    k : int
        Step of the velocity loop.
    drivetrain : Drivetrain
        Robot, motors, friction and period.
    imperfect : Imperfections
        Delay and disturbance; the disturbance acts on the wheels directly, not through the motors.
    motor_limit : float
        Of each motor [N m], beside its stall torque; 0 means none.

    Returns
    -------
    tuple of PlantState, MotorState, DelayLine, WheelTorque and WheelTorque
        State, motors and line at the period's end; the torque that would act now without limits, lag and friction; the
        applied torque: the mean over the period of the torque at the motors' shafts, before any friction [N m].
    """
    late, acting = delayed(line, torque)
    request = saturate(saturate(acting, motor_limit), drivetrain.axle.stall_torque)
    outside = disturbed(WheelTorque(0.0, 0.0), imperfect.disturbance, k, drivetrain.plant.dt)
    moved, after, applied = motorised_step(state, motors, request, outside, drivetrain)
    return moved, after, late, acting, applied
