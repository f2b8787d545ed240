"""Fig. 10 and 11: the structure of the fuzzy controller, and the function that wraps its bearing."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch
from matplotlib.transforms import Bbox

from chapter_figures.figure import ALL, ChapterFigure
from chapter_figures.membership_figures import ANGULAR_NAMES, LINEAR_NAMES
from chapter_figures.runs import Runs
from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.control.fuzzy import FuzzyGains, memberships, surface
from mobile_robot_control.figures.drawing import legend
from mobile_robot_control.figures.figure import WIDTH
from mobile_robot_control.figures.palette import BLUE, GREY, INK, LINES, TINT, style

_APART = FuzzyGains(a=1.0, b=(0.5, 0.4, 1.2, 2.0, 1.8, 3.0), c=(0.0, 1.0, 2.0, 3.0, 4.0), d=(0.0, 1.0, 2.0))
"""Membership functions far enough apart that one rule fires alone at each point below; outputs index the names."""
_DISTANCES = (('S', 0.0), ('G', 2.0))
_BEARINGS = (('GN', -math.pi), ('SN', -1.2), ('Z', 0.0), ('SP', 1.2), ('GP', math.pi))


def rules() -> dict[tuple[str, str], tuple[str, str]]:
    """Return the ten rules of the law, evaluated where each fires alone: the names of o_1, o_2 by those of i_1, i_2."""
    found = {}
    for near, distance in _DISTANCES:
        for side, bearing in _BEARINGS:
            output = surface(distance, bearing, _APART)
            found[near, side] = (LINEAR_NAMES[round(output.linear)], ANGULAR_NAMES[round(output.angular)])
    return found


def _box(axes: Axes, x: float, y: float, width: float, height: float, text: str) -> None:
    """Draw a box with a text in its middle."""
    axes.add_patch(FancyBboxPatch((x, y), width, height, boxstyle='round,pad=0,rounding_size=0.02', facecolor=TINT,
                                  edgecolor=GREY))
    axes.text(x + width / 2, y + height / 2, text, ha='center', va='center', fontsize=9)


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate('', end, start, arrowprops={'arrowstyle': '-|>', 'color': INK, 'linewidth': 1.0})


def _structure(_runs: Runs) -> Figure:
    """Draw Fig. 10: inputs, rules and outputs of the fuzzy controller."""
    with style():
        figure = Figure(figsize=(WIDTH, 4.2), layout='constrained')
        flow, table = figure.subplots(2, 1, height_ratios=[1.5, 1.0])
        for axes in (flow, table):
            axes.set_axis_off()
            axes.set_xlim(0.0, 1.0)
            axes.set_ylim(0.0, 1.0)
        for y, label in ((0.56, '$i_1$'), (0.06, '$i_2$')):
            flow.text(0.02, y + 0.19, label, va='center')
            _arrow(flow, (0.07, y + 0.19), (0.12, y + 0.19))
            _box(flow, 0.12, y, 0.24, 0.38, '')
            _arrow(flow, (0.36, y + 0.19), (0.45, 0.5 + (y - 0.31) * 0.4))
        _miniatures(flow)
        _box(flow, 0.45, 0.2, 0.16, 0.6, '10 rules\nproduct')
        _arrow(flow, (0.61, 0.5), (0.69, 0.5))
        _box(flow, 0.69, 0.2, 0.18, 0.6, 'weighted\naverage')
        for y, label in ((0.65, '$o_1$'), (0.35, '$o_2$')):
            _arrow(flow, (0.87, y), (0.94, y))
            flow.text(0.95, y, label, va='center')
        _rule_table(table)
    return figure


def _miniatures(axes: Axes) -> None:
    """Draw the membership functions into the boxes of the inputs."""
    distances, bearings = np.linspace(0.0, 2.0, 60), np.linspace(-math.pi, math.pi, 120)
    far = [memberships(float(x), 0.0, _APART) for x in distances]
    aside = [memberships(0.0, float(x), _APART) for x in bearings]
    for y, held, fields in ((0.58, far, ('near', 'far')), (0.08, aside, memberships(0.0, 0.0, _APART)._fields[2:])):
        for field, (color, _) in zip(fields, LINES, strict=False):
            axes.plot(np.linspace(0.13, 0.35, len(held)), [y + 0.33 * getattr(m, field) for m in held], color=color,
                      linewidth=1.1, zorder=3)


def _rule_table(axes: Axes) -> None:
    found = rules()
    cells = [[', '.join(found[near, side]) for side, _ in _BEARINGS] for near, _ in _DISTANCES]
    drawn = axes.table(cells, rowLabels=[f'$i_1$ is {near}' for near, _ in _DISTANCES],
                       colLabels=[f'$i_2$ is {side}' for side, _ in _BEARINGS], cellLoc='center',
                       bbox=Bbox.from_bounds(0.14, 0.2, 0.85, 0.75))
    drawn.auto_set_font_size(False)
    drawn.set_fontsize(9)
    for cell in drawn.get_celld().values():
        cell.set_edgecolor(GREY)
        cell.set_facecolor(TINT)
        cell.get_text().set_color(INK)
    axes.text(0.56, 0.08, 'each cell: $o_1$, $o_2$', ha='center', va='center', fontsize=9)


def _wrapping(_runs: Runs) -> Figure:
    """Draw Fig. 11: wrap_angle beside the printed formula."""
    angles = np.linspace(-3.0 * math.pi, 3.0 * math.pi, 1201)[1:-1]
    wrapped = np.array([wrap_angle(float(x)) for x in angles])
    printed = 2.0 * np.arctan(np.tan(angles / 2.0))
    with style():
        figure = Figure(figsize=(WIDTH, 2.9), layout='constrained')
        axes = figure.subplots()
        for values, options in ((wrapped, {'color': GREY, 'linewidth': 4.0, 'label': 'wrap_angle(x)'}),
                                (printed, {'color': BLUE, 'label': '2 atan(tan(x / 2)), Eq. (35)'})):
            broken = np.where(np.abs(np.diff(values, append=values[-1])) > math.pi, np.nan, values)
            axes.plot(angles, broken, **options)
        axes.set_xticks([n * math.pi for n in range(-3, 4)], ['-3π', '-2π', '-π', '0', 'π', '2π', '3π'])
        axes.set_yticks([-math.pi, 0.0, math.pi], ['-π', '0', 'π'])
        axes.set_xlabel('x [rad]')
        axes.set_ylabel('f(x) [rad]')
        legend(axes)
    return figure


STRUCTURE_FIGURES = (
    ChapterFigure('10', 'Fuzzy controller with 2 inputs and 2 outputs', 'From the memberships of distance and bearing '
                  'through ten rules to two velocities. The rules are what the law answers where each fires alone.',
                  ALL, _structure),
    ChapterFigure('11', 'Diagram of the function f', 'What the code does (grey) is the printed formula (blue), which '
                  'has no value at odd multiples of π.', ALL, _wrapping),
)
