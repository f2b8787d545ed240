"""Paths drawn on the page: planned for a preview, and sent to the cart."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
from collections.abc import Mapping, Sequence
from typing import Any

from nav_msgs.msg import Path
from rclpy.node import Node

from mobile_robot_control.configuration.nodes import ReferenceCartParameters, path_request
from mobile_robot_control.messages.writing import path_message
from mobile_robot_control.parameters.checking import build
from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.cart import Placement
from mobile_robot_control.reference.curve import PATH
from mobile_robot_control.reference.path_parameters import NO_FILE
from mobile_robot_control.reference.planned_path import plan
from mobile_robot_control.reference.waypoints import checked_waypoints
from mobile_robot_control.ros.services.qos import LATCHED
from mobile_robot_control.topics import PATH_TOPIC

Point = tuple[float, float]
MOST = 2000
"""Most points of a drawn path."""
_SHOWN = 400
_STRAIGHT = 0.1
"""[1/m]: a smaller curvature counts as none."""


def on_a_path(values: Mapping[str, Any], limits: Mapping[str, float]) -> dict[str, Any]:
    """Return the changes of the cart's parameters for paths with limits of `timing`."""
    wanted: dict[str, Any] = {'curve': PATH, **Placement()._asdict(), **limits}
    wanted['center'] = list(wanted['center'])
    return {name: value for name, value in wanted.items() if name in values and values[name] != value}


def planned(values: Mapping[str, Any], points: Sequence[Point], limits: Mapping[str, float]) -> dict[str, Any]:
    """
    Plan a path from rest to rest.

    Parameters
    ----------
    values : mapping of str to object
        Of the reference cart.
    points : sequence of (float, float)
        Waypoints [m].
    limits : mapping of str to float
        Parameters of `timing` that replace the cart's.

    Returns
    -------
    dict of str to object
        `x`, `y` [m] and `speed` [m/s] of points along it, `limit` and `bends` (whether it bends there); `duration` [s],
        `length` [m], and `active`, the share of the time in which each limit is active.

    Raises
    ------
    ParameterError
        If it is infeasible.

    """
    known = {name: value for name, value in values.items() if name in declarations(ReferenceCartParameters)}
    cart = build(ReferenceCartParameters, known | on_a_path(known, limits) | {'path.file': NO_FILE})
    waypoints = checked_waypoints([(f'point {n}', point) for n, point in enumerate(points, start=1)], 'the path')
    course = plan(path_request(cart, waypoints))
    count = len(course.limit)
    shown = sorted({n * (count - 1) // (_SHOWN - 1) for n in range(_SHOWN)})
    poses = [course.reference(float(course.times[n])).pose for n in shown]
    return {'x': [round(pose.x, 4) for pose in poses], 'y': [round(pose.y, 4) for pose in poses],
            'speed': [round(float(course.speeds[n]), 4) for n in shown],
            'limit': [course.limit[n] for n in shown],
            'bends': [bool(abs(course.grid.curvature[n]).max() > _STRAIGHT) for n in shown],
            'duration': course.period, 'length': course.length, 'active': course.shares()}


def start_of(points: Sequence[Point]) -> list[float]:
    """Return the pose [m, m, rad] at the first point, directed to the second."""
    (x, y), (ahead, left) = points[:2]
    return [x, y, math.atan2(left - y, ahead - x)]


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

    def send(self, points: Sequence[Point], frame: str) -> None:
        """Publish a path [m] in a frame."""
        if self._publisher is None:
            self._publisher = self._node.create_publisher(Path, PATH_TOPIC, LATCHED)
        self._publisher.publish(path_message(frame, [Pose(x, y, 0.0) for x, y in points]))
