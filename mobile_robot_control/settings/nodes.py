"""The parameters of the four nodes, shared or their own, and the rules between them."""

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.control.approach import ApproachParameters
from mobile_robot_control.control.laws import LAWS, PositionControl, select
from mobile_robot_control.control.limits import TrackingLimit
from mobile_robot_control.control.velocity_laws import VelocityControl, velocity_instability
from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.model.base import base_violations
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.motors import Motor
from mobile_robot_control.model.plant import VELOCITY, PlantModel
from mobile_robot_control.model.sensors import is_ideal, sensor_violations
from mobile_robot_control.parameters.declaration import INLINE, Field, ParameterError, declarations, rule
from mobile_robot_control.quantities import period_nanoseconds
from mobile_robot_control.reference.cart import CurveParameters, Placement, too_fast_to_send
from mobile_robot_control.reference.course import Course, FileRequest, make_course
from mobile_robot_control.reference.curves import OF_FILES, PATH, TRAJECTORY
from mobile_robot_control.reference.goal import GoalParameters
from mobile_robot_control.reference.led_course import driven_course
from mobile_robot_control.reference.localisation import CorrectionSchedule, Localisation
from mobile_robot_control.reference.path_parameters import (
    NO_FILE,
    Drive,
    PathParameters,
    PathRequest,
    Timing,
    path_violations,
)
from mobile_robot_control.reference.trajectory_parameters import TrajectoryParameters, TrajectoryRequest
from mobile_robot_control.reference.waiting import WaitParameters
from mobile_robot_control.reference.waypoints import Waypoints
from mobile_robot_control.settings.recorded_path import trajectory_in, waypoints_in
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import LOOPS, PATH_TOPIC, LoopGraph, extended, with_truth

_LONGEST_STEP = 3600.0
"""Longest wall time of a step when simulated time is slowed down [s]."""


class PlantParameters(NamedTuple):
    """Parameters of the node `plant`."""

    shared: Annotated[Shared, INLINE] = Shared()
    initial_pose: Annotated[
        tuple[float, ...],
        Field('m, m, rad', "start of the robot: x, y, yaw; if not given, the commands start it at the cart's start; a "
                           'change acts at the next reset', length=3, live=True)
    ] = (1.0, 0.0, 0.5 * math.pi)
    duration: Annotated[
        float, Field('s', 'length of the run; 0 for no end', minimum=0.0)
    ] = 0.0
    real_time_factor: Annotated[
        float, Field('', 'simulated time per wall time in lockstep, 0 for as fast as possible: larger runs faster',
                     minimum=0.0, live=True)
    ] = 1.0
    paused: Annotated[
        bool, Field('', 'hold simulated time and repeat the present messages; on the wall clock, only joint_states',
                    live=True)
    ] = False
    hold_at: Annotated[
        float, Field('s', 'time from the start at which the run holds, like paused, until this is raised; 0 for none',
                     minimum=0.0, live=True)
    ] = 0.0
    publish_clock: Annotated[bool, Field('', 'publish /clock in lockstep (one robot a domain)')] = True
    publish_tf: Annotated[bool, Field('', 'publish odom -> base_link on /tf if tf2_ros is installed')] = True
    torque_timeout: Annotated[
        float, Field('s', 'wall clock: time without wheel_torques after which the torque falls to zero: larger '
                     'drives on longer', above=0.0)
    ] = 0.1
    pose_covariance_diagonal: Annotated[
        tuple[float, ...], Field('m², rad²', 'diagonal of the covariance of odom.pose', minimum=0.0, length=6)
    ] = (0.0,) * 6
    twist_covariance_diagonal: Annotated[
        tuple[float, ...], Field('m²/s², rad²/s²', 'diagonal of the covariance of odom.twist', minimum=0.0, length=6)
    ] = (0.0,) * 6
    model: Annotated[PlantModel, INLINE] = PlantModel()


class VelocityControllerParameters(NamedTuple):
    """Parameters of the node `velocity_controller`."""

    shared: Annotated[Shared, INLINE] = Shared()
    control: Annotated[VelocityControl, INLINE] = VelocityControl()
    cmd_vel_timeout: Annotated[
        float, Field('s', 'wall clock: time without cmd_vel after which the command falls to zero, 0 for never: larger '
                     'drives on longer',
                     minimum=0.0)
    ] = 0.5
    max_wheel_torque: Annotated[
        float, Field('N m', 'limit of each torque asked for, with anti-windup, 0 for none: larger accelerates harder',
                     minimum=0.0, live=True)
    ] = 0.0

    @property
    def gains(self) -> VelocityGains:
        """Gains of the PI law."""
        gains: VelocityGains = self.control.gains
        return gains


class PositionControllerParameters(NamedTuple):
    """Parameters of the node `position_controller`."""

    shared: Annotated[Shared, INLINE] = Shared()
    control: Annotated[PositionControl, INLINE] = PositionControl()
    input_timeout: Annotated[
        float, Field('s', 'wall clock: time without odom or reference after which cmd_vel falls to zero: larger '
                     'drives on longer', above=0.0)
    ] = 0.5
    compensate_latency: Annotated[
        bool, Field('', 'extrapolate odometry along its arc over its age: odom_latency, plus the age of its stamp on '
                        'the wall clock, plus the steps of a repeated sample in lockstep; on the wall clock, also the '
                        'reference', live=True)
    ] = False
    odom_latency: Annotated[
        float, Field('s', "age of odometry that its stamp does not show, optionally plus the base's dead time: larger "
                          'extrapolates farther', minimum=0.0, live=True)
    ] = 0.0
    stop_on_odom_conflict: Annotated[
        bool, Field('', 'wall clock: stop the robot while several publishers of odom contradict each other',
                    live=True)
    ] = True
    # in addition to those of the command in `control`, which rollouts take
    limits: TrackingLimit = TrackingLimit()
    approach: ApproachParameters = ApproachParameters()


class ReferenceCartParameters(NamedTuple):
    """Parameters of the node `reference_cart`."""

    shared: Annotated[Shared, INLINE] = Shared()
    curve: Annotated[CurveParameters, INLINE] = CurveParameters()
    waiting: Annotated[WaitParameters, INLINE] = WaitParameters()
    path: PathParameters = PathParameters()
    trajectory: TrajectoryParameters = TrajectoryParameters()
    timing: Timing = Timing()
    localisation: Localisation = Localisation()
    goal: GoalParameters = GoalParameters()
    # as for the plant, for the torques of a path
    motor: Motor = Motor()
    friction: Friction = Friction()


class Configuration(NamedTuple):
    """The parameters of all four nodes of a run, by node name."""

    plant: PlantParameters = PlantParameters()
    velocity_controller: VelocityControllerParameters = VelocityControllerParameters()
    position_controller: PositionControllerParameters = PositionControllerParameters()
    reference_cart: ReferenceCartParameters = ReferenceCartParameters()


PACE = ('paused', 'hold_at', 'real_time_factor')
"""Parameters of the plant that change no number of a run and cause no events."""
NODES: dict[str, Any] = dict(Configuration.__annotations__)
"""The parameter class of each node, by node name."""


def latency_cautions(parameters: PositionControllerParameters) -> Iterator[str]:
    """Report an age of odometry that is compensated twice."""
    if parameters.compensate_latency and parameters.odom_latency and parameters.shared.stamps_samples:
        yield (f'odom_latency = {parameters.odom_latency:g} s is added to the age that the stamps of odom show '
               '(odometry_stamped: sampled): leave it out, unless odometry is older than its stamps')


def has_exact_odometry(plant: PlantParameters) -> bool:
    """Return whether `odom` is the true motion, so that the plant needs no `ground_truth`."""
    noise = plant.model.imperfections.noise
    return is_ideal(plant.model.encoders, plant.model.odometry) and not (any(noise.pose) or noise.velocity)


def path_of(cart: ReferenceCartParameters) -> PathRequest | tuple[()]:
    """Return the path of the cart; () without one."""
    if cart.curve.curve != PATH:
        return ()
    if cart.path.file == NO_FILE:
        raise ParameterError([f"curve = '{PATH}' needs path.file, a file of waypoints: only nodes take a path from the "
                              f'topic {PATH_TOPIC}'])
    waypoints, frame = waypoints_in(cart.path), cart.shared.path_frame_id
    if waypoints.frame not in ('', frame):
        raise ParameterError([f"path.file = '{cart.path.file}' is in the frame '{waypoints.frame}', and path_frame is "
                              f"'{frame}'; set path_frame, or transform it"])
    if waypoints.waits and cart.shared.is_localised:
        raise ParameterError([f"path.file = '{cart.path.file}' has a column wait, for the frame of odometry alone; "
                              f"leave it out, or path_frame = '{cart.shared.path_frame}'"])
    return path_request(cart, waypoints)


def request_of(cart: ReferenceCartParameters) -> FileRequest | tuple[()]:
    """Return the path or the trajectory of the cart; () for a curve."""
    if cart.curve.curve != TRAJECTORY:
        return path_of(cart)
    if cart.trajectory.file == NO_FILE:
        raise ParameterError([f"curve = '{TRAJECTORY}' needs trajectory.file, a file of points with times"])
    points = trajectory_in(cart.trajectory)
    if points.frame not in ('', cart.shared.odom_frame_id):
        raise ParameterError([f"trajectory.file = '{cart.trajectory.file}' is in the frame '{points.frame}', and "
                              f"odometry in '{cart.shared.odom_frame_id}'; transform it"])
    return TrajectoryRequest(points, cart.trajectory, cart.timing, _drive(cart))


def has_turns(cart: ReferenceCartParameters) -> bool:
    """Return whether the course of the cart may lead backwards or turn on the spot."""
    return cart.curve.curve == TRAJECTORY or cart.path.uses_headings


def _drive(cart: ReferenceCartParameters) -> Drive:
    motor = cart.motor
    return Drive(cart.shared.robot, cart.friction.coulomb, motor.stall_torque, motor.no_load_speed)


def path_request(cart: ReferenceCartParameters, waypoints: Waypoints) -> PathRequest:
    """Return the request to plan a path through waypoints."""
    return PathRequest(waypoints, cart.path, cart.timing, _drive(cart))


def awaits_path(cart: ReferenceCartParameters) -> bool:
    """Return whether the cart stands until a path arrives on the topic `path`."""
    return cart.curve.curve == PATH and cart.path.file == NO_FILE


def course_of(cart: ReferenceCartParameters) -> Course:
    """Return the course of the cart, without corrections."""
    return make_course(cart.curve.curve, cart.curve.placement, request_of(cart))


def correction_schedule(cart: ReferenceCartParameters) -> CorrectionSchedule | tuple[()]:
    """Return the schedule of drawn corrections; () for none."""
    if cart.localisation.rate <= 0.0:
        return ()
    tick = period_nanoseconds(cart.shared.position_rate)
    return CorrectionSchedule(cart.localisation, tick, cart.shared.reference_horizon)


def driven_course_of(cart: ReferenceCartParameters) -> Course:
    """Return the course of the cart, with the corrections that are drawn."""
    return driven_course(cart.curve.curve, cart.curve.placement, request_of(cart), correction_schedule(cart))


def awaits_corrections(cart: ReferenceCartParameters) -> bool:
    """Return whether a localisation places the course: none that is drawn."""
    return cart.shared.is_localised and not correction_schedule(cart)


def known_course(cart: ReferenceCartParameters) -> Course | None:
    """Return the course of the cart in the frame of odometry; None if it awaits a path or a localisation places it."""
    return None if awaits_path(cart) or awaits_corrections(cart) else driven_course_of(cart)


def with_options(loop: LoopGraph, shared: Shared) -> LoopGraph:
    """Return a loop with the topics that the shared parameters require."""
    return extended(loop, shared.reference_horizon > 0, shared.feedforward.enabled, shared.has_odom_time)


def loop_of(plant: PlantParameters) -> LoopGraph:
    """Return the loop of a plant."""
    loop = with_options(LOOPS[plant.model.drive], plant.shared)
    return loop if has_exact_odometry(plant) else with_truth(loop)


def parameter_names() -> dict[str, set[str]]:
    """Return the dotted names of the parameters of each node, with those of the laws registered now."""
    return _parameter_names(LAWS.version)


@lru_cache(maxsize=1)
def _parameter_names(_version: int) -> dict[str, set[str]]:
    """Return the names, which depend on the registered laws alone."""
    return {node: set(declarations(group)) for node, group in NODES.items()}


@rule
def _law_prepares(parameters: PositionControllerParameters) -> Iterator[str]:
    try:
        select(parameters.control, 1.0 / parameters.shared.position_rate)
    except ParameterError as error:
        yield from error.violations


@rule
def _horizon_is_long(parameters: PositionControllerParameters) -> Iterator[str]:
    law, horizon = LAWS[parameters.control.controller_type], parameters.shared.reference_horizon
    if law.horizon > horizon:
        yield (f"the law '{law.name}' needs reference_horizon = {law.horizon} or more, which is {horizon}; write it "
               "under '/**', and start the nodes again")


@rule
def _trajectory_is_planned(cart: ReferenceCartParameters) -> Iterator[str]:
    """Refuse a trajectory that cannot be driven, and parameters without effect."""
    if cart.curve.curve != TRAJECTORY:
        for name, value in cart.trajectory._asdict().items():
            if value != getattr(TrajectoryParameters(), name):
                yield (f"trajectory.{name} = {value} is of curve = '{TRAJECTORY}', and curve is '{cart.curve.curve}'; "
                       'leave it out, or change curve')
        return
    missing = list(_unplaced(cart))
    if cart.timing.speed_factor != 1.0:
        missing.append(f'timing.speed_factor = {cart.timing.speed_factor:g} slows down a path, and a trajectory has '
                       'times of its own; leave it out')
    if cart.shared.is_localised:
        missing.append(f"path_frame = '{cart.shared.path_frame}' does not hold for a trajectory, which is in the frame "
                       'of odometry; leave it out')
    yield from missing
    if not missing:
        try:
            course_of(cart)
        except ParameterError as error:
            yield from error.violations


@rule
def _path_is_planned(cart: ReferenceCartParameters) -> Iterator[str]:
    """Refuse an incomplete path, an infeasible one, and parameters without effect."""
    if cart.curve.curve != PATH:
        for name, value in cart.path._asdict().items():
            # those that are live, as the curve is
            if value != getattr(PathParameters(), name) and name not in ('turn_back', 'planning_time'):
                yield (f"path.{name} = {value} is of curve = '{PATH}', and curve is '{cart.curve.curve}'; leave it "
                       'out, or change curve')
        return
    missing = [*_unplaced(cart), *path_violations(cart.path, cart.timing, cart.motor.stall_torque)]
    yield from missing
    if not missing and not awaits_path(cart):
        try:
            course_of(cart)
        except ParameterError as error:
            yield from error.violations


def _unplaced(cart: ReferenceCartParameters) -> Iterator[str]:
    """Yield the parameters that place a curve, which are meaningless for a path."""
    for name, value in cart.curve.placement._asdict().items():
        if value != getattr(Placement(), name):
            decides = 'waypoints and timing decide' if cart.curve.curve == PATH else 'its points decide'
            yield (f"{name} = {list(value) if isinstance(value, tuple) else value} places a curve, and curve is "
                   f"'{cart.curve.curve}': leave it out, since {decides}")


@rule
def _corrections_have_a_frame(cart: ReferenceCartParameters) -> Iterator[str]:
    localisation, shared = cart.localisation, cart.shared
    if localisation.rate > 0.0 and not (shared.is_localised and shared.lockstep):
        yield (f'localisation.rate = {localisation.rate:g} Hz draws corrections of path_frame in lockstep, and '
               f"path_frame is '{shared.path_frame}'; set path_frame to map and lockstep to true, or leave it out")
    if localisation.rate > 0.0 and awaits_path(cart):
        yield ('localisation.rate draws corrections for a path.file or a curve; name one, or leave it out: a path of '
               'the topic path is corrected by /tf')
    if shared.is_localised and not (shared.lockstep or cart.waiting.wait):
        yield (f"path_frame = '{shared.path_frame}' needs wait = True on the wall clock, so that the cart stands while "
               'the correction is missing')


@rule
def _horizon_can_be_sent(parameters: ReferenceCartParameters) -> Iterator[str]:
    if parameters.shared.reference_horizon and parameters.curve.curve not in OF_FILES:
        yield from too_fast_to_send(parameters.curve)


@rule
def _duration_has_a_step(plant: PlantParameters) -> Iterator[str]:
    rate = plant.shared.velocity_rate
    # a run without a step would have no end
    if plant.duration > 0.0 and round(plant.duration * rate) < 1:
        yield (f'duration = {plant.duration} s is too short for a step at velocity_rate = {rate} Hz; '
               f'take at least {1.0 / rate:g} s, or 0 for no end')


@rule
def _a_step_ends(plant: PlantParameters) -> Iterator[str]:
    factor, period = plant.real_time_factor, 1.0 / plant.shared.velocity_rate
    # below some 1e-13 a step would last longer than the longest timer
    if factor > 0.0 and factor * _LONGEST_STEP < period:
        yield (f'real_time_factor = {factor} is too small: a step would take {period / factor:.3g} s of wall time; '
               f'write at least {period / _LONGEST_STEP:g}, or 0 for as fast as possible')


@rule
def _queues_are_short(plant: PlantParameters) -> Iterator[str]:
    model, shared = plant.model, plant.shared
    grid = period_nanoseconds(shared.velocity_rate), period_nanoseconds(shared.position_rate)
    if model.drive == VELOCITY:
        yield from base_violations(model.base, *grid)
    yield from sensor_violations(model.encoders, model.odometry, *grid)


@rule
def velocity_loop_is_stable(parameters: VelocityControllerParameters) -> Iterator[str]:
    """Refuse gains that are unstable at the rate; a base that takes velocity commands has no such loop."""
    shared = parameters.shared
    fault = velocity_instability(
        parameters.control, shared.robot, parameters.max_wheel_torque, shared.velocity_rate, shared.lockstep)
    if fault:
        yield fault
