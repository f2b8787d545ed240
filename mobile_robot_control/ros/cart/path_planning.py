"""The reference cart's response to a path, a goal or a correction: a function of messages, for any process."""

import time
from functools import partial
from typing import NamedTuple

from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_goal, read_or_refuse, read_path
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.reference.joining import join
from mobile_robot_control.reference.led_course import led_over, waypoints_in_odometry
from mobile_robot_control.reference.motion import PathMotion, Rest
from mobile_robot_control.reference.path_parameters import PathRequest
from mobile_robot_control.reference.stopping import moves, stop
from mobile_robot_control.reference.way_to_goal import drive_to
from mobile_robot_control.reference.waypoints import checked_waypoints
from mobile_robot_control.topics import GOAL, PATH_TOPIC

PATH_KIND, GOAL_KIND = 'nav_msgs/msg/Path', 'geometry_msgs/msg/PoseStamped'


class PathQuestion(NamedTuple):
    """
    A message on `path` or `goal_pose`, or a correction of the present path, and the motion that the cart leaves for it.

    Attributes
    ----------
    message : bytes
        Serialised, from any source; empty for a correction.
    frame : str
        Of the path.
    request : PathRequest
        Limits; for a correction, the present path in its own frame.
    correction : Pose
        Of the frame of odometry in that of the path.
    at : Reference
        Pose and motion of the cart at the start of the path.
    course : PathMotion or None
        Its course then; None if it stands.
    time : float
        Since the start of that course [s].
    anew : bool
        Whether the limits have changed since.
    topic : str
        Of the message.

    """

    message: bytes
    frame: str
    request: PathRequest
    correction: Pose
    at: Reference
    course: PathMotion | None
    time: float
    anew: bool = False
    topic: str = PATH_TOPIC


class PathAnswer(NamedTuple):
    """
    The cart's next motion.

    Attributes
    ----------
    planned : PathMotion or None
        None if it stands.
    points : list of tuple of float
        Positions of the message [m], with headings [rad] if `path` uses them; of a goal the pose; none for a stop, or a
        correction.
    route : PathRequest or None
        The path, in its own frame; None for a stop.
    correction : Pose or None
        The correction that leads the cart over; None for an answer to a message.
    topic : str
        Of the message.
    refusal : tuple of str
        A reason and its detail; () without a refusal.
    goes_on : bool
        Whether the cart continues its present motion.
    stops : bool
        Whether the cart stops along its present motion, which needs no plan on the wall clock.
    seconds : float
        CPU time of the planning [s].

    """

    planned: PathMotion | None
    points: list[tuple[float, ...]]
    refusal: tuple[str, ...] = ()
    goes_on: bool = False
    stops: bool = False
    seconds: float = 0.0
    route: PathRequest | None = None
    correction: Pose | None = None
    topic: str = PATH_TOPIC


def answer(question: PathQuestion) -> PathAnswer:
    """Plan the cart's next motion from a message, a stop, too."""
    answered = planned(question)
    return _stopped(question, answered) if answered.stops else answered


def planned(question: PathQuestion) -> PathAnswer:
    """Plan the cart's next motion from a message, but for a stop."""
    begun = time.process_time()
    answering = _corrected if not question.message else _driven if question.topic == GOAL else _answered
    answered = answering(question)
    return answered._replace(topic=question.topic, seconds=time.process_time() - begun)


def _corrected(question: PathQuestion) -> PathAnswer:
    """Lead the cart over to where its path lies now; where that keeps no limits, it goes on."""
    request, course = question.request, question.course
    assert course is not None  # noqa: S101 (for mypy: a cart that stands for good is not led)
    try:
        planned, _ = led_over(course, request, question.correction, question.time, course)
    except ParameterError:
        return PathAnswer(None, [], goes_on=True, route=request)
    assert isinstance(planned, PathMotion)  # noqa: S101 (for mypy: of a path)
    return PathAnswer(planned, [], route=request, correction=question.correction)


def _driven(question: PathQuestion) -> PathAnswer:
    """Drive to a goal; the cart goes on where that keeps no limits."""
    try:
        goal = read_or_refuse(
            GOAL_KIND, (partial(deserialise, GOAL_KIND), partial(read_goal, frame=question.frame)), question.message)
        # rounded, as the headings of a path
        goal = goal._replace(heading=round(goal.heading, 9))
        planned, route = drive_to(goal, question.request, question.at, _rest(question), question.correction, GOAL)
    except RefusedMessageError as error:
        return PathAnswer(None, [], (error.reason, error.detail), goes_on=True)
    except ParameterError as error:
        return PathAnswer(None, [], ('cannot be driven', '; '.join(error.violations)), goes_on=True)
    return PathAnswer(planned, [goal], route=route)


def _answered(question: PathQuestion) -> PathAnswer:
    try:
        poses = read_or_refuse(
            PATH_KIND, (partial(deserialise, PATH_KIND), partial(read_path, frame=question.frame)), question.message)
    except RefusedMessageError as error:
        return PathAnswer(None, [], (error.reason, error.detail), goes_on=True)
    request = question.request
    # rounded, so that the heading of a message that is written again is the same to the last bit
    points = [(pose.x, pose.y, round(pose.heading, 9)) if request.path.uses_headings else pose[:2] for pose in poses]
    refusal: tuple[str, ...] = ()
    if points:
        try:
            rows = [(f'pose {n}', dict(zip(('x', 'y', 'heading'), one, strict=False))) for n, one in enumerate(points)]
            waypoints = checked_waypoints(rows, PATH_TOPIC)
            route = request._replace(waypoints=waypoints_in_odometry(waypoints, question.correction))
            planned = join(route, question.at, _rest(question), question.anew)
            return PathAnswer(planned, points, goes_on=planned is None, route=request._replace(waypoints=waypoints))
        except ParameterError as error:
            refusal = 'cannot be driven', '; '.join(error.violations)
    return PathAnswer(None, [], refusal, stops=True)


def stopping(refusal: tuple[str, ...]) -> tuple[str, ...]:
    """Say in a refusal, if there is one, that the cart stops."""
    return (refusal[0], f'the cart stops: {refusal[1]}') if refusal else ()


def _stopped(question: PathQuestion, refused: PathAnswer) -> PathAnswer:
    """Plan the stop: not on the rest of the present path, which the planner has given up."""
    rest, answered = _rest(question), refused._replace(stops=False)
    if rest is None or not moves(question.at):
        return answered._replace(goes_on=bool(refused.refusal))
    try:
        return answered._replace(
            planned=stop(rest, question.request, question.at), refusal=stopping(refused.refusal))
    except ParameterError as error:
        return answered._replace(
            refusal=('cannot be driven', '; '.join([*refused.refusal[1:], *error.violations])), goes_on=True)


def _rest(question: PathQuestion) -> Rest | None:
    """Return the present motion from the question's time on; None if the cart stands at its end."""
    course = question.course
    return course.rest(question.time) if course and question.time < course.period else None
