"""What the page publishes: pushes on the simulated robot, and sketched paths, planned for a preview."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from itertools import pairwise
from typing import Any, NamedTuple

from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from nav_msgs.msg import Path
from rclpy.node import Node

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.dashboard.parameter_book import ParameterBook
from mobile_robot_control.dashboard.service_calls import NoAnswerError
from mobile_robot_control.messages.writing import path_message
from mobile_robot_control.parameters.declaration import ParameterError, build, declarations
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.cart import Placement
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.reference.motion import Turn, plan
from mobile_robot_control.reference.path_parameters import NO_FILE, REVERSE
from mobile_robot_control.reference.waypoints import checked_waypoints
from mobile_robot_control.ros.shared.qos import LATCHED, PUBLISHED
from mobile_robot_control.settings.nodes import ReferenceCartParameters, path_request
from mobile_robot_control.topics import DISTURBANCE, PATH_TOPIC

DISTURBANCES = {'ArrowUp': (0.25, 0.0), 'ArrowDown': (-0.25, 0.0), 'ArrowLeft': (0.0, 1.5), 'ArrowRight': (0.0, -1.5)}
"""By key: changes of the velocity [m/s] and the yaw rate [rad/s]."""
_PATIENCE = 3.0
"""[s] of wall time to discover the plant."""


class Disturbances:
    """
    Publishes pushes; the plant accepts only one publisher, so it is made at the first push.

    Parameters
    ----------
    node : Node
        Node of the publisher.
    book : ParameterBook
        Provides mass, inertia and rate.

    """

    def __init__(self, node: Node, book: ParameterBook) -> None:
        self._node, self._book = node, book
        self._publisher: Any = None
        self._waiting: list[tuple[float, Any, Future[str]]] = []

    def push(self, key: str) -> Future[str]:
        """Push the robot; the future has a text, or NoAnswerError."""
        done: Future[str] = Future()
        names = ('robot.mass', 'robot.inertia', 'velocity_rate')
        mass, inertia, rate = (self._book.value('plant', name) for name in names)
        if not all(isinstance(number, float) for number in (mass, inertia, rate)):
            done.set_exception(NoAnswerError('there is no simulated plant to push; start one'))
            return done
        faster, turning = DISTURBANCES[key]
        # held over one step of the velocity grid: F = m Δv / dt; stamp 0 means the next step
        push = WrenchStamped(wrench=Wrench(force=Vector3(x=mass * faster * rate),
                                           torque=Vector3(z=inertia * turning * rate)))
        push.header.frame_id = self._book.value('plant', 'base_frame_id', '')
        if self._publisher is None:
            self._publisher = self._node.create_publisher(WrenchStamped, DISTURBANCE, PUBLISHED)
        self._waiting.append((time.monotonic() + _PATIENCE, push, done))
        self.look()
        return done

    def look(self) -> None:
        """Publish pushes that wait for the discovery of the plant."""
        if not self._waiting:
            return
        if self._publisher.get_subscription_count() > 0:
            for _, push, done in self._waiting:
                self._publisher.publish(push)
                done.set_result('')
            self._waiting.clear()
        elif time.monotonic() > self._waiting[0][0]:
            _, _, done = self._waiting.pop(0)
            done.set_exception(NoAnswerError(f'nothing takes {DISTURBANCE}; only a simulated plant can be pushed'))


class SketchPoint(NamedTuple):
    """
    A point of a sketched path.

    Attributes
    ----------
    x, y : float
        Position [m].
    mark : str
        With BACKWARDS it is reached backwards, with ON_THE_SPOT the robot turns there.

    """

    x: float
    y: float
    mark: str = ''


BACKWARDS, ON_THE_SPOT = 'b', 't'
MOST = 2000
"""Most points of a sketched path."""
_LIMITS = ('timing.max_linear_velocity', 'timing.max_wheel_torque', 'timing.max_angular_velocity')
"""Parameters that a page sets along with a path."""
_SHOWN = 400
_STRAIGHT = 0.1
"""[1/m]: a smaller curvature counts as none."""
_TURN = 0.2
"""[rad]: where the robot stops, a smaller difference of headings is no turn."""
_APART = 1e-6
"""[rad] from the heading of one pose to the next: equal ones mean nothing."""


def sketch_of(request: Mapping[str, Any]) -> tuple[list[SketchPoint], dict[str, float]]:
    """Return the points and the limits of a request of the page; raise ParameterError for others."""
    points, limits = request.get('points'), request.get('limits')
    if not (isinstance(points, list) and 1 < len(points) <= MOST and all(
            isinstance(point, list) and len(point) in (2, 3) and all(type(part) in (int, float) for part in point[:2])
            and all(isinstance(mark, str) for mark in point[2:]) for point in points)):
        raise ParameterError([f'a path has 2 to {MOST} points'])
    if not (isinstance(limits, dict) and all(
            name in _LIMITS and type(limit) in (int, float) for name, limit in limits.items())):
        raise ParameterError([f'a path has limits of {" and ".join(_LIMITS)}'])
    return ([SketchPoint(float(x), float(y), *mark) for x, y, *mark in points],
            {name: float(limit) for name, limit in limits.items()})


def sketch_poses(points: Sequence[SketchPoint]) -> list[Pose]:
    """Return the poses of a sketched path; a turn on the spot is two of them."""
    legs = [math.atan2(after.y - before.y, after.x - before.x) + (math.pi if BACKWARDS in after.mark else 0.0)
            for before, after in pairwise(points)]
    poses = []
    for n, point in enumerate(points):
        arrival, departure = legs[max(0, n - 1)], legs[min(n, len(legs) - 1)]
        turn = wrap_angle(departure - arrival)
        switches = 0 < n < len(legs) and (BACKWARDS in point.mark) != (BACKWARDS in points[n + 1].mark)
        stops = switches or ON_THE_SPOT in point.mark
        poses.append(Pose(point.x, point.y, arrival if stops else arrival + 0.5 * turn))
        if stops and abs(turn) > _TURN:
            poses.append(Pose(point.x, point.y, departure))
    return [pose._replace(heading=wrap_angle(pose.heading) + n * _APART) for n, pose in enumerate(poses)]


def path_changes(
    values: Mapping[str, Any], points: Sequence[SketchPoint], limits: Mapping[str, float]
) -> dict[str, Any]:
    """Return the changes of the cart's parameters for a sketched path with limits of `timing`."""
    wanted: dict[str, Any] = {'curve': PATH, **Placement()._asdict(), **limits}
    wanted['center'] = list(wanted['center'])
    if any(point.mark for point in points):
        wanted['path.turn_back'] = REVERSE
    return {name: value for name, value in wanted.items() if name in values and values[name] != value}


def path_preview(
    values: Mapping[str, Any], points: Sequence[SketchPoint], limits: Mapping[str, float]
) -> dict[str, Any]:
    """
    Plan a path from rest to rest.

    Parameters
    ----------
    values : mapping of str to object
        Of the reference cart.
    points : sequence of SketchPoint
        Waypoints.
    limits : mapping of str to float
        Parameters of `timing` that replace the cart's.

    Returns
    -------
    dict of str to object
        `x`, `y` [m] and `speed` [m/s], negative backwards, of points along it, `limit` and `bends` (whether it bends
        there); `turns`, the places [m] of turns on the spot; `poses`, of its waypoints; `duration` [s], `length` [m],
        and `active`, the share of the time in which each limit is active.

    Raises
    ------
    ParameterError
        If it is infeasible.

    """
    declared = {name: value for name, value in values.items() if name in declarations(ReferenceCartParameters)}
    cart = build(ReferenceCartParameters, declared | path_changes(declared, points, limits) | {'path.file': NO_FILE})
    poses = sketch_poses(points)
    rows = [(f'point {n}', pose._asdict() if cart.path.uses_headings else pose[:2])
            for n, pose in enumerate(poses, start=1)]
    course = plan(path_request(cart, checked_waypoints(rows, 'the path')))
    count = len(course.limit)
    shown = sorted({n * (count - 1) // (_SHOWN - 1) for n in range(_SHOWN)})
    at = [course.reference(float(course.times[n])) for n in shown]
    return {'x': [round(one.pose.x, 4) for one in at], 'y': [round(one.pose.y, 4) for one in at],
            'speed': [round(one.velocity.linear, 4) for one in at],
            'limit': [course.limit[n] for n in shown],
            'bends': [abs(one.velocity.angular) > _STRAIGHT * abs(one.velocity.linear) for one in at],
            'turns': [part.reference(0.0).pose[:2] for part in course.parts if isinstance(part, Turn)],
            'poses': [(pose.x, pose.y, round(pose.heading, 6)) for pose in poses],
            'duration': course.period, 'length': course.length, 'active': course.shares()}


class PathSender:
    """
    Publishes paths, also for a cart that comes later.

    Parameters
    ----------
    node : Node
        Node of the publisher, which is made at the first path.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher: Any = None

    def send(self, points: Sequence[SketchPoint], frame: str) -> None:
        """Publish a sketched path in a frame."""
        if self._publisher is None:
            self._publisher = self._node.create_publisher(Path, PATH_TOPIC, LATCHED)
        self._publisher.publish(path_message(frame, sketch_poses(points)))
