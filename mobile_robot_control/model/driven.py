"""The plant with motors and friction: from the torques asked for to motion over one sampling period."""

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.jit import jitable, jitable_apart
from mobile_robot_control.model import coupled
from mobile_robot_control.model.actuators import DelayLine, delayed, saturate
from mobile_robot_control.model.disturbance import disturbed
from mobile_robot_control.model.drivetrain import Drivetrain
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.friction import sign
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.motors import MotorState
from mobile_robot_control.model.plant import Imperfections
from mobile_robot_control.model.prediction import coriolis_torque, is_uneventful, stands, uneventful_step
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.model.stick_slip import MOST_EVENTS, advance_wheels, engaged
from mobile_robot_control.model.wheels import Forcing, Rolling, Wheel
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity


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
    count = coupled.substeps(drivetrain.plant.dt)
    h = drivetrain.plant.dt / count
    for _ in range(count):
        middle = rolling
        for share in (0.5, 1.0):
            pair = coriolis_torque(WheelVelocity(middle.right.speed, middle.left.speed), robot)
            held = Forcing(forcing.asked, WheelTorque(outside.right + pair.right, outside.left + pair.left),
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
    ), WheelTorque(forcing.asked.right - end.right.lacking / dt, forcing.asked.left - end.left.lacking / dt)


@jitable
def motorised_step(
    state: PlantState, motors: MotorState, asked: WheelTorque, outside: WheelTorque, drivetrain: Drivetrain
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
    asked : WheelTorque
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
        fading = WheelTorque(motors.torque.right - asked.right, motors.torque.left - asked.left)
    else:
        fading = WheelTorque(0.0, 0.0)
    after = MotorState(WheelTorque(asked.right + drivetrain.remainder * fading.right,
                                   asked.left + drivetrain.remainder * fading.left))
    mean = WheelTorque(asked.right + drivetrain.mean_remainder * fading.right,
                       asked.left + drivetrain.mean_remainder * fading.left)
    speed = wheel_velocity(state.velocity, drivetrain.plant.robot)
    if (stands(speed.right, asked.right, fading.right, outside.right, coulomb)
            and stands(speed.left, asked.left, fading.left, outside.left, coulomb)):
        return state, after, mean
    forcing = Forcing(asked, outside, state.pose.heading)
    if drivetrain.predictable and is_uneventful(speed, fading, forcing, drivetrain):
        torque = WheelTorque(asked.right + outside.right - coulomb * sign(speed.right),
                             asked.left + outside.left - coulomb * sign(speed.left))
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
    asked = saturate(saturate(acting, motor_limit), drivetrain.axle.stall_torque)
    outside = disturbed(WheelTorque(0.0, 0.0), imperfect.disturbance, k, drivetrain.plant.dt)
    moved, after, applied = motorised_step(state, motors, asked, outside, drivetrain)
    return moved, after, late, acting, applied
