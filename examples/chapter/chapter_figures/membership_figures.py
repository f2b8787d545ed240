"""Fig. 12 to 15 and 17 to 22: membership functions before and after the search, and the control surfaces."""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from chapter_figures import fuzzy_gains
from chapter_figures.figure import ALL, ChapterFigure
from chapter_figures.runs import FUZZY_TRIFOLIUM, Runs
from mobile_robot_control.control.fuzzy import FuzzyGains, memberships, surface
from mobile_robot_control.figures.drawing import legend
from mobile_robot_control.figures.figure import WIDTH, Floats
from mobile_robot_control.figures.palette import INK, LINES, style

GainsSource = Callable[[Runs], FuzzyGains]
"""Returns the gains to draw."""
_NEAR = (('near', 'S'), ('far', 'G'))
_SIDES = (('great_negative', 'GN'), ('small_negative', 'SN'), ('zero', 'Z'), ('small_positive', 'SP'),
          ('great_positive', 'GP'))
LINEAR_NAMES, ANGULAR_NAMES = ('FB', 'B', 'S', 'F', 'FF'), ('CW', 'ST', 'CCW')
"""Of the output values, ascending: fast backwards to fast forward, clockwise to counter-clockwise."""
_PI_TICKS = ([-np.pi, -np.pi / 2, 0.0, np.pi / 2, np.pi], ['-π', '-π/2', '0', 'π/2', 'π'])


def _canvas() -> tuple[Figure, Axes]:
    """Make a figure with empty axes."""
    figure = Figure(figsize=(WIDTH, 2.7), layout='constrained')
    return figure, figure.subplots()


def _inputs(gains: GainsSource, bearing: bool) -> Callable[[Runs], Figure]:
    """Return the function that draws the membership functions of the bearing or of the distance."""
    def draw(runs: Runs) -> Figure:
        found = gains(runs)
        points = np.linspace(-np.pi, np.pi, 1441) if bearing else np.linspace(0.0, 2.0 * found.a, 400)
        held = [memberships(0.0, float(x), found) if bearing else memberships(float(x), 0.0, found) for x in points]
        with style():
            figure, axes = _canvas()
            for (field, name), (color, dashes) in zip(_SIDES if bearing else _NEAR, LINES, strict=False):
                axes.plot(points, [getattr(m, field) for m in held], color=color, linestyle=dashes, label=name)
            axes.set_xlabel('$i_2$, bearing of the cart [rad]' if bearing else '$i_1$, distance to the cart [m]')
            axes.set_ylabel('membership')
            if bearing:
                axes.set_xticks(*_PI_TICKS)
            legend(axes, 5)
        return figure

    return draw


def _outputs(gains: GainsSource, angular: bool) -> Callable[[Runs], Figure]:
    """Return the function that draws the output values of the angular or the linear velocity."""
    def draw(runs: Runs) -> Figure:
        found = gains(runs)
        values, names = (found.d, ANGULAR_NAMES) if angular else (found.c, LINEAR_NAMES)
        with style():
            figure, axes = _canvas()
            span = max(values) - min(values)
            heights = _heights(values, 0.09 * span)
            for value, name, height, (color, _) in zip(values, names, heights, LINES, strict=False):
                axes.vlines(value, 0.0, 1.0, color=color, linewidth=2.5)
                axes.plot(value, 1.0, 'o', color=color)
                axes.annotate(f'{name} {value:.3g}', (value, 1.0), (value, height), color=INK, ha='center',
                              arrowprops={'arrowstyle': '-', 'color': color, 'linewidth': 0.6})
            axes.set_xlim(min(values) - 0.12 * span, max(values) + 0.12 * span)
            axes.set_ylim(0.0, max(heights) + 0.2)
            axes.set_yticks([0.0, 0.5, 1.0])
            axes.set_ylabel('membership')
            axes.set_xlabel('$o_2$, angular velocity [rad/s]' if angular else '$o_1$, linear velocity [m/s]')
        return figure

    return draw


def _heights(values: tuple[float, ...], apart: float) -> list[float]:
    """Return the heights of the names of ascending values, higher for one that is near the value before it."""
    heights: list[float] = []
    for n, value in enumerate(values):
        near = n > 0 and value - values[n - 1] < 2.0 * apart
        heights.append(heights[-1] + 0.2 if near else 1.12)
    return heights


def _grid(gains: FuzzyGains) -> tuple[Floats, Floats, Floats]:
    """Return bearings [rad], distances [m] and both outputs [m/s], [rad/s], the latter of shape (121, 241, 2)."""
    bearings, distances = np.linspace(-np.pi, np.pi, 241), np.linspace(0.0, 2.0 * gains.a, 121)
    outputs = [[surface(float(i1), float(i2), gains) for i2 in bearings] for i1 in distances]
    return bearings, distances, np.array(outputs)


def _surface(angular: bool) -> Callable[[Runs], Figure]:
    """Return the function that draws the control surface of the angular or the linear velocity."""
    def draw(runs: Runs) -> Figure:
        bearings, distances, outputs = _grid(fuzzy_gains.evolved(runs))
        with style():
            # placed by hand: layout engines do not know the extent of what is drawn in perspective
            figure = Figure(figsize=(WIDTH, 4.4))
            axes = figure.add_subplot(projection='3d')
            axes.set_position((0.02, 0.03, 0.92, 0.89))
            x, y = np.meshgrid(bearings, distances)
            axes.plot_surface(x, y, outputs[:, :, int(angular)], cmap='cividis', rcount=60, ccount=120, linewidth=0,
                              antialiased=False, rasterized=True)
            for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
                axis.set_pane_color((0.5, 0.5, 0.5, 0.08))
            axes.set_xlabel('$i_2$ [rad]', labelpad=10.0)
            axes.set_ylabel('$i_1$ [m]', labelpad=10.0)
            axes.yaxis.set_major_locator(MaxNLocator(4))
            axes.zaxis.set_major_locator(MaxNLocator(5))
            axes.tick_params(axis='z', pad=6.0)
            axes.set_title('$o_2$, angular velocity [rad/s]' if angular else '$o_1$, linear velocity [m/s]')
            axes.set_xticks(*_PI_TICKS)
            axes.view_init(elev=28.0, azim=-125.0 if angular else -58.0)
        return figure

    return draw


_BEFORE = 'Random values of a first generation: '
_AFTER = 'After the evolution: '
_FILE = f'cat config/{FUZZY_TRIFOLIUM.file}'
INITIAL_FIGURES = (
    ChapterFigure('12', 'Random initial setup of input variable i_1', _BEFORE + 'S falls to zero over [0, a], G is the '
                  'rest.', ALL, _inputs(fuzzy_gains.initial, bearing=False)),
    ChapterFigure('13', 'Random initial setup of input variable i_2', _BEFORE + 'the shapes lie anywhere, but no '
                  'bearing is without one.', ALL, _inputs(fuzzy_gains.initial, bearing=True)),
    ChapterFigure('14', 'Random initial setup of output variable o_1', _BEFORE + 'five velocities in order.', ALL,
                  _outputs(fuzzy_gains.initial, angular=False)),
    ChapterFigure('15', 'Random initial setup of output variable o_2', _BEFORE + 'three rotations in order.', ALL,
                  _outputs(fuzzy_gains.initial, angular=True)),
)
EVOLVED_FIGURES = (
    ChapterFigure('17', 'Membership functions for i_1', _AFTER + 'the cart counts as far from a on.',
                  _FILE, _inputs(fuzzy_gains.evolved, bearing=False)),
    ChapterFigure('18', 'Membership functions for i_2', _AFTER + 'a robot on the curve uses the shapes that '
                  'fire near zero bearing.', _FILE, _inputs(fuzzy_gains.evolved, bearing=True)),
    ChapterFigure('19', 'Membership functions for o_1 (fast backwards, backwards, stop, forward and fast forward)',
                  _AFTER + 'the velocities that the rules mix.', _FILE, _outputs(fuzzy_gains.evolved, angular=False)),
    ChapterFigure('20', 'Membership functions for ω_2 (clockwise, straight, counter clockwise)',
                  _AFTER + 'the rotations that the rules mix.', _FILE, _outputs(fuzzy_gains.evolved, angular=True)),
    ChapterFigure('21', 'Control surface for ω_1', 'The linear velocity grows with the distance while the cart is '
                  'ahead.', _FILE, _surface(angular=False)),
    ChapterFigure('22', 'Control surface for o_2', 'The rotation depends on the bearing alone and has its sign.',
                  _FILE, _surface(angular=True)),
)
