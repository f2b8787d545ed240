"""Parts of drawings of the plane: points relative to a pose, lines, arrows, names, the robot to scale."""

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mobile_robot_control.figures.drawing import triangle
from mobile_robot_control.figures.figure import WIDTH, Floats
from mobile_robot_control.figures.palette import GREY, INK, TINT
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import Pose


def plane(height: float) -> tuple[Figure, Axes]:
    """Make a figure of a height [in] with empty axes of the plane [m], both to the same scale."""
    figure = Figure(figsize=(WIDTH, height), layout='constrained')
    axes = figure.subplots()
    axes.set_aspect('equal', adjustable='box' if height > 4.1 else 'datalim')
    axes.set_xlabel('x [m]')
    axes.set_ylabel('y [m]')
    return figure, axes


def along(pose: Pose, ahead: float, aside: float = 0.0) -> tuple[float, float]:
    """Return x and y of the point at a distance ahead of a pose and to its left, all in [m]."""
    cos, sin = math.cos(pose.heading), math.sin(pose.heading)
    return pose.x + cos * ahead - sin * aside, pose.y + sin * ahead + cos * aside


def draw_pose(axes: Axes, pose: Sequence[float] | Floats, size: float, color: str) -> None:
    """Draw the robot at a pose x, y [m], heading [rad], as a triangle of a length [m] that points ahead."""
    corners = triangle(pose, size)
    axes.fill(corners[:, 0], corners[:, 1], facecolor='none', edgecolor=color, linewidth=1.1)


def draw_line(axes: Axes, start: tuple[float, float], end: tuple[float, float], **options: Any) -> None:
    """Draw a straight line between two points x, y [m]."""
    axes.plot([start[0], end[0]], [start[1], end[1]], **options)


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], color: str, both: bool = False) -> None:
    """Draw an arrow between two points x, y [m]; with heads at both ends if it measures a length."""
    axes.annotate('', end, start, arrowprops={'arrowstyle': '<|-|>' if both else '-|>', 'color': color,
                                              'linewidth': 1.4, 'shrinkA': 0, 'shrinkB': 0})


def name(axes: Axes, at: tuple[float, float], text: str, color: str = INK) -> None:
    """Draw a text centred at a point x, y [m]."""
    axes.text(*at, text, color=color, ha='center', va='center')


def robot_on(axes: Axes, pose: Pose, robot: Robot) -> None:
    """Draw the body, wheels and axle of the robot to scale; the pose is that of the axle's centre A."""
    half, radius = 0.5 * robot.wheel_separation, robot.wheel_radius
    body = [along(pose, ahead, aside) for ahead, aside in
            ((-0.3 * half, -half), (-0.3 * half, half), (1.0 * half, half), (1.5 * half, 0.0), (1.0 * half, -half))]
    axes.fill(*zip(*body, strict=True), facecolor=TINT, edgecolor=GREY)
    for side in (half, -half):
        corners = [along(pose, ahead, side + aside) for ahead, aside in
                   ((-radius, -0.012), (radius, -0.012), (radius, 0.012), (-radius, 0.012))]
        axes.fill(*zip(*corners, strict=True), facecolor=INK, edgecolor=INK, zorder=3)
    draw_line(axes, along(pose, 0.0, half), along(pose, 0.0, -half), color=INK, linewidth=1.5)
