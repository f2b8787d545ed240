"""A run as a small animation: robot, its trail, reference cart and, if torques are known, their bars."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from mobile_robot_control.figures.drawing import triangle
from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.figures.palette import BLUE, FAINT, GREY, INK, ORANGE, style
from mobile_robot_control.runs.series import Series

_FRAME_TIME, _LAST_FRAME_TIME = 80, 1200
"""[ms] for which a frame is shown."""
_COLORS = 32
"""Colours in the palette of a GIF."""


class _Motion(NamedTuple):
    """Time [s] and poses of each frame; each wheel's largest torque [N m] since the previous frame, if known."""

    times: Floats
    robot: Floats
    cart: Floats
    torque: Floats


def _held(series: Series, topic: str, columns: tuple[str, ...], times: Floats) -> Floats:
    """Return columns of a topic at some times, each value held until the next message."""
    lines = [series.line(topic, column) for column in columns]
    place = np.clip(np.searchsorted(lines[0].time, times, side='right') - 1, 0, None)
    return np.stack([line.value[place] for line in lines], axis=1)


def _motion(series: Series, frames: int) -> _Motion:
    """Return the motion in so many frames, evenly in time."""
    recorded = series.time(series.motion)
    times = np.linspace(recorded[0], recorded[-1], frames)
    pose = ('x', 'y', 'heading')
    cart = _held(series, 'reference', pose, times) if series.time('reference').size else np.zeros((0, 3))
    torque = np.zeros((frames if series.torque('right').time.size else 0, 2))
    for n, wheel in enumerate(('right', 'left')):
        line = series.torque(wheel)
        for frame, part in enumerate(np.split(line.value, np.searchsorted(line.time, times[1:], side='right'))):
            if part.size and torque.size:
                torque[frame, n] = part[np.argmax(np.abs(part))]
    return _Motion(times, _held(series, series.motion, pose, times), cart, torque)


def _plane(axes: Axes, series: Series) -> None:
    """Draw the reference, on axes wide enough for the path of the robot."""
    for topic, options in (('reference', {'color': GREY, 'linewidth': 3.0}), (series.motion, {'alpha': 0.0})):
        axes.plot(series.line(topic, 'x').value, series.line(topic, 'y').value, **options)
    axes.set_aspect('equal', adjustable='datalim')
    axes.margins(0.08)
    axes.set_xlabel('x [m]')
    axes.set_ylabel('y [m]')


def _bars(axes: Axes, torque: Floats) -> Any:
    """Draw the bars of the left and the right torque."""
    bars = axes.bar(['left', 'right'], [0.0, 0.0], color=[ORANGE, BLUE], width=0.6)
    largest = float(np.max(np.abs(torque), initial=0.1))
    axes.set_ylim(-1.1 * largest, 1.1 * largest)
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.grid(visible=False, axis='x')
    axes.set_ylabel('wheel torque [N m]')
    return bars


def _painter(series: Series, motion: _Motion) -> tuple[Figure, Callable[[int], None]]:
    """Return the figure, and a function that draws the n-th frame on it."""
    figure = Figure(figsize=(5.6, 3.5), dpi=90, layout='constrained')
    if motion.torque.size:
        plane, wheels = figure.subplots(1, 2, width_ratios=[3.2, 1.0])
        bars = _bars(wheels, motion.torque)
    else:
        plane, bars = figure.subplots(), ()
    _plane(plane, series)
    size = 0.11 * max(*np.ptp(motion.robot[:, :2], axis=0), 0.1)
    trail, = plane.plot([], [], color=BLUE, linewidth=1.8)
    cart, = plane.fill([0.0], [0.0], facecolor=FAINT, edgecolor=INK, linewidth=1.0, zorder=3)
    robot, = plane.fill([0.0], [0.0], facecolor=BLUE, edgecolor=INK, linewidth=1.0, zorder=4)
    x, y = series.line(series.motion, 'x'), series.line(series.motion, 'y')

    def paint(frame: int) -> None:
        passed = int(np.searchsorted(x.time, motion.times[frame], side='right'))
        trail.set_data(x.value[:passed], y.value[:passed])
        robot.set_xy(triangle(motion.robot[frame], size))
        if motion.cart.size:
            cart.set_xy(triangle(motion.cart[frame], size))
        # the bar of the left wheel is the left one
        for n, bar in enumerate(bars):
            bar.set_height(motion.torque[frame, 1 - n])
        plane.set_title(f't = {motion.times[frame]:.1f} s', loc='left')

    return figure, paint


def animate(series: Series, file: Path, frames: int = 96) -> None:
    """
    Write an animation of a run.

    Parameters
    ----------
    series : Series
        With at least two `odom` messages; ValueError is raised otherwise.
    file : Path
        GIF or WebP, by its ending.
    frames : int
        Number of pictures.
    """
    if series.time('odom').size < 2:
        raise ValueError('a run without odometry cannot be animated')
    with style():
        motion = _motion(series, frames)
        figure, paint = _painter(series, motion)
        canvas: Any = FigureCanvasAgg(figure)
        paint(0)
        canvas.draw()
        # the axes stay in place from frame to frame
        figure.set_layout_engine('none')
        pictures = []
        for frame in range(frames):
            paint(frame)
            canvas.draw()
            pictures.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert('RGB'))
    write_frames(pictures, file)


def write_frames(pictures: Sequence[Image.Image], file: Path, colors: int = _COLORS) -> None:
    """Write pictures of one size as an animation that stops at its end: WebP, or GIF of so many colours."""
    times = [_FRAME_TIME] * (len(pictures) - 1) + [_LAST_FRAME_TIME]
    if file.suffix == '.webp':
        pictures[0].save(file, save_all=True, append_images=pictures[1:], duration=times, loop=0, quality=60, method=4)
        return
    # one palette for all frames, from a frame that contains everything
    palette = pictures[len(pictures) // 2].quantize(colors)
    frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    frames[0].save(file, save_all=True, append_images=frames[1:], duration=times, loop=0, optimize=True)
