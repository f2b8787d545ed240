"""Fig. 2, 5, 7, 8 and 9: the robot, the cart and the seeking rotation, drawn from states of runs."""

import math

import numpy as np
from matplotlib.figure import Figure

from chapter_figures.figure import ALL, ChapterFigure
from chapter_figures.plane_drawing import along, arrow, draw_line, draw_pose, name, plane, robot_on
from chapter_figures.runs import HYBRID_LEMNISCATE, ORDINARY_LEMNISCATE, Runs
from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.control.tracking_error import bearing
from mobile_robot_control.figures.drawing import legend, triangle
from mobile_robot_control.figures.figure import WIDTH
from mobile_robot_control.figures.palette import BLUE, GREEN, GREY, INK, ORANGE, PINK, style
from mobile_robot_control.loop.closed_loop import PositionTick
from mobile_robot_control.quantities import Pose
from mobile_robot_control.runs.series import Series

_SEEK = 4.0
"""[s] of the run in Fig. 9."""


def _geometry(runs: Runs) -> Figure:
    """Draw Fig. 2: the robot to scale at the start of a run."""
    plant = runs.configuration(ORDINARY_LEMNISCATE).plant
    robot, start = plant.shared.robot, Pose(*plant.initial_pose)
    half, offset = 0.5 * robot.wheel_separation, robot.com_offset
    with style():
        figure, axes = plane(4.4)
        robot_on(axes, start, robot)
        a, c = (start.x, start.y), along(start, offset)
        arrow(axes, a, along(start, 2.1 * half), BLUE)
        arrow(axes, a, along(start, 0.0, 1.7 * half), BLUE)
        name(axes, along(start, 2.2 * half), '$x_m$', BLUE)
        name(axes, along(start, 0.0, 1.85 * half), '$y_m$', BLUE)
        draw_line(axes, a, (start.x + 2.0 * half, start.y), color=GREY, linestyle=':')
        turn = np.linspace(0.0, start.heading, 30)
        axes.plot(start.x + 1.6 * half * np.cos(turn), start.y + 1.6 * half * np.sin(turn), color=ORANGE)
        name(axes, (start.x + 1.75 * half * math.cos(0.5 * start.heading),
                     start.y + 1.75 * half * math.sin(0.5 * start.heading)), 'θ', ORANGE)
        for point, text, ahead, aside in ((a, 'A', -0.022, -0.018), (c, 'C', 0.022, -0.02)):
            axes.plot(*point, 'o', color=ORANGE if text == 'C' else INK, markersize=5.0, zorder=4)
            name(axes, along(Pose(*point, start.heading), ahead, aside), text)
        arrow(axes, along(start, -0.5 * half, 0.0), along(start, -0.5 * half, half), GREEN, both=True)
        name(axes, along(start, -1.05 * half, 0.5 * half), f'R = {half:g} m', GREEN)
        arrow(axes, along(start, 0.0, -1.35 * half), along(start, offset, -1.35 * half), GREEN, both=True)
        name(axes, along(start, 0.5 * offset, -1.6 * half), f'd = {offset:g} m', GREEN)
        name(axes, along(start, 0.45 * half, 1.15 * half), f'2r = {2.0 * robot.wheel_radius:g} m', GREEN)
        # texts do not widen the axes
        axes.set_xlim(start.x - 1.6 * half, start.x + 2.6 * half)
        axes.set_ylim(start.y - 2.0 * half, start.y + 2.1 * half)
    return figure


def _poses(series: Series, n: int) -> tuple[Pose, Pose]:
    """Return the poses of robot and cart at the n-th position tick."""
    robot, cart = (Pose(*(float(series.line(topic, name).value[n]) for name in ('x', 'y', 'heading')))
                   for topic in ('odom', 'reference'))
    return robot, cart


def _concept(runs: Runs) -> Figure:
    """Draw Fig. 5: robot, cart and tracking error at one time of a run."""
    measured = runs.measured(HYBRID_LEMNISCATE)
    series, robot = measured.series, runs.configuration(HYBRID_LEMNISCATE).plant.shared.robot
    errors = (series.line('tracking_error', name).value for name in ('longitudinal', 'lateral', 'heading'))
    # the time at which the smallest of all three is largest, so that each is visible
    now = int(np.argmax(np.min([np.abs(error) for error in errors], axis=0)))
    pose, cart = _poses(series, now)
    ahead, aside = (float(series.line('tracking_error', name).value[now]) for name in ('longitudinal', 'lateral'))
    with style():
        figure, axes = plane(4.2)
        axes.plot(series.line('reference', 'x').value[::40], series.line('reference', 'y').value[::40], color=GREY,
                  linewidth=3.0, label='reference')
        axes.plot(series.line('odom', 'x').value[:now:20], series.line('odom', 'y').value[:now:20], color=BLUE,
                  label='robot')
        for shown, color in ((pose, BLUE), (cart, GREY)):
            axes.fill(*triangle(shown, 0.6 * robot.wheel_separation).T, facecolor='none', edgecolor=color,
                      linewidth=2.0, zorder=4)
        foot = along(pose, ahead)
        arrow(axes, (pose.x, pose.y), foot, ORANGE)
        arrow(axes, foot, (cart.x, cart.y), GREEN)
        draw_line(axes, (cart.x, cart.y), along(cart, 0.3), color=GREY, linestyle=':')
        draw_line(axes, (cart.x, cart.y), along(Pose(cart.x, cart.y, pose.heading), 0.3), color=BLUE, linestyle=':')
        name(axes, along(pose, 0.5 * ahead, -0.07 * math.copysign(1.0, aside)), '$e_1$', ORANGE)
        name(axes, along(pose, ahead + math.copysign(0.05, ahead), 0.5 * aside), '$e_2$', GREEN)
        turned = wrap_angle(cart.heading - pose.heading)
        sweep = pose.heading + np.linspace(0.0, turned, 30)
        axes.plot(cart.x + 0.2 * np.cos(sweep), cart.y + 0.2 * np.sin(sweep), color=PINK)
        name(axes, along(Pose(cart.x, cart.y, pose.heading + 0.5 * turned), 0.26), '$e_3$', PINK)
        around = 0.35
        axes.set_xlim(min(pose.x, cart.x) - around, max(pose.x, cart.x) + around)
        axes.set_ylim(min(pose.y, cart.y) - around, max(pose.y, cart.y) + around)
        legend(axes)
    return figure


def _unseen(runs: Runs) -> Figure:
    """Draw Fig. 7: robot and cart at a start with the cart out of sight."""
    measured = runs.measured(ORDINARY_LEMNISCATE)
    series, robot = measured.series, runs.configuration(ORDINARY_LEMNISCATE).plant.shared.robot
    pose, cart = _poses(series, 0)
    first = measured.metrics['initial_wheel_torque']
    with style():
        figure, axes = plane(3.6)
        robot_on(axes, pose, robot)
        draw_line(axes, (pose.x, pose.y), along(pose, 0.45), color=BLUE, linestyle='--', label='straight ahead')
        draw_line(axes, (pose.x, pose.y), (cart.x, cart.y), color=ORANGE, label='to the cart')
        axes.fill(*triangle(cart, 0.1).T, facecolor='none', edgecolor=INK, linewidth=1.6)
        axes.text(0.98, 0.03, f'first torques\nof the ordinary\ncontroller:\nright {first["right"]:.0f} N m\n'
                  f'left {first["left"]:.0f} N m', transform=axes.transAxes, ha='right')
        axes.margins(0.1)
        legend(axes)
    return figure


def _generator(runs: Runs) -> Figure:
    """Draw Fig. 8: bearing and state of the hybrid law over time."""
    ticks = list(runs.seeking(HYBRID_LEMNISCATE, 8.0))[::20]
    time = [sample.time for sample, _ in ticks]
    rows: tuple[tuple[str, list[float]], ...] = (
        ('bearing [rad]', [bearing(sample.tick.error) for sample, _ in ticks]),
        ('d', [_direction(sample.tick) if state.seen == 0.0 else math.nan for sample, state in ticks]),
        ('$ω_s$ [rad/s]', [state.seek for _, state in ticks]),
        ('z, α', [state.seen for _, state in ticks]),
    )
    with style():
        figure = Figure(figsize=(WIDTH, 5.0), layout='constrained')
        panels = figure.subplots(len(rows), 1, sharex=True)
        for axes, (label, values) in zip(panels, rows, strict=True):
            axes.plot(time, values, color=BLUE, label='z')
            axes.set_ylabel(label)
        panels[-1].plot(time, [state.fade for _, state in ticks], color=ORANGE, linestyle='--', label='α')
        legend(panels[-1])
        panels[-1].set_xlabel('time [s]')
        figure.align_ylabels(list(panels))
    return figure


def _direction(tick: PositionTick) -> float:
    """Return d of Eq. (31)."""
    return 1.0 if bearing(tick.error) > 0.0 else -1.0


def _seeking(runs: Runs) -> Figure:
    """Draw Fig. 9: poses of robot and cart until the cart is in sight."""
    ticks = list(runs.seeking(HYBRID_LEMNISCATE, _SEEK))
    seen = next((n for n, (_, state) in enumerate(ticks) if state.seen), len(ticks) - 1)
    with style():
        figure, axes = plane(4.0)
        robot, cart = ([sample.tick.pose for sample, _ in ticks],
                       [sample.tick.reference.pose for sample, _ in ticks])
        axes.plot([pose.x for pose in cart], [pose.y for pose in cart], color=GREY, linewidth=3.0, label='cart')
        axes.plot([pose.x for pose in robot], [pose.y for pose in robot], color=BLUE, label='robot')
        for n in np.linspace(0, seen, 6).astype(int):
            draw_pose(axes, robot[n], 0.14, BLUE)
            draw_pose(axes, cart[n], 0.07, GREY)
            draw_line(axes, (robot[n].x, robot[n].y), (cart[n].x, cart[n].y), color=ORANGE, linewidth=0.8,
                  linestyle='-' if n == seen else ':', label='_' if n != seen else 'line of sight')
        axes.set_title(f'seen at t = {ticks[seen][0].time:.2f} s', loc='right')
        legend(axes)
    return figure


SCENE_FIGURES = (
    ChapterFigure('2', 'The representation of a nonholonomic mobile robot', 'The robot to scale, from the parameters '
                  'and the start of a run: axle centre A, mass centre C, heading θ.', ALL, _geometry),
    ChapterFigure('5', 'The concept of tracking of a virtual reference robot', 'A moment of a run: the cart lies e1 '
                  'ahead of the robot and e2 to its left, and is turned by e3.', HYBRID_LEMNISCATE.command(), _concept),
    ChapterFigure('7', "Tracking robot doesn't \"see\" virtual robot", 'The start of the runs on the lemniscate: the '
                  'cart lies off the straight line ahead of the robot.', ORDINARY_LEMNISCATE.command(), _unseen),
    ChapterFigure('8', 'Producing ω_s(t)', 'While the cart is not in sight its side d drives the seeking rotation up; '
                  'once seen (z = 1) ω_s stays and α fades backstepping in.', HYBRID_LEMNISCATE.command(), _generator),
    ChapterFigure('9', '"Seeking" a virtual robot', 'The robot turns on the spot, faster and faster, until the cart '
                  'lies straight ahead, and then sets off.', HYBRID_LEMNISCATE.command(), _seeking),
)
