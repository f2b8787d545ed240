"""The page of a plan: the path coloured by its active limit, and the motion along it with its limits."""

from collections.abc import Sequence
from html import escape

import numpy as np

from mobile_robot_control.figures.drawing import draw
from mobile_robot_control.figures.figure import (
    COMMAND,
    REFERENCE,
    VALUE,
    Figure,
    Floats,
    Line,
    Panel,
    RobotMark,
    Trace,
    plane,
)
from mobile_robot_control.figures.palette import LINES, as_svg
from mobile_robot_control.pages import page
from mobile_robot_control.planning.planning import Plan, plan_of
from mobile_robot_control.reference.path_parameters import PathRequest
from mobile_robot_control.runs.run import Run
from mobile_robot_control.settings.nodes import Configuration, awaits_path, path_of

_OTHERS = 'others'


def _parts_of(plan: Plan) -> list[tuple[str, Floats]]:
    """Return the active limits, at most as many as there are colours, each with a mask of its points."""
    names = list(plan.active)
    chosen = names if len(names) <= len(LINES) else names[:len(LINES) - 1]
    limit = np.array(plan.limit)
    parts = [(name or 'none', limit == name) for name in chosen]
    if chosen != names:
        parts.append((_OTHERS, ~np.isin(limit, chosen)))
    # an interval is drawn to its end
    return [(name, active | np.concatenate([[False], active[:-1]])) for name, active in parts]


def _coloured(x: Floats, y: Floats, plan: Plan) -> list[Trace]:
    """Return a line as one curve for each limit."""
    return [Trace(VALUE, number, name, Line(np.where(active, x, np.nan), np.where(active, y, np.nan)))
            for number, (name, active) in enumerate(_parts_of(plan))]


def _limits(plan: Plan, limit: float, signs: tuple[float, ...]) -> list[Trace]:
    """Return lines at a limit; none if it is 0."""
    ends = plan.time[[0, -1]]
    return [Trace(COMMAND, 0, 'limit', Line(ends, np.full(2, sign * limit))) for sign in signs if limit]


def _directions(plan: Plan) -> tuple[list[Trace], list[RobotMark]]:
    """Return the stretches backwards, and poses in all stretches and turns; none for a single stretch forwards."""
    way = np.sign(plan.velocity[:, 0])
    changes = np.flatnonzero(np.diff(way)) + 1
    parts = [part for part in np.split(np.arange(len(way)), changes) if np.any(plan.velocity[part])]
    if len(parts) == 1 and way[parts[0][0]] > 0.0:
        return [], []
    x, y = np.where(way[:, None] < 0.0, plan.pose[:, :2], np.nan).T
    middles = [np.searchsorted(plan.time, plan.time[part[[0, -1]]].mean()) for part in parts]
    return ([Trace(COMMAND, 0, 'backwards', Line(x, y))] if (way < 0.0).any() else [],
            [RobotMark(0, *plan.pose[n].tolist()) for n in (0, *middles)])


def plan_figures(plan: Plan) -> list[Figure]:
    """Return the figures of a plan: the motion coloured by its limits, and the wheels."""
    timing = plan.limits
    names = tuple(name for name, _ in _parts_of(plan))
    backwards, poses = _directions(plan)
    speeds = [Panel(name, name, unit, (*_limits(plan, timing[limit], signs),
                                       *_coloured(plan.time, plan.velocity[:, n], plan)))
              for n, name, unit, limit, signs in (
                  (0, 'v', 'm/s', 'max_linear_velocity', (1.0, -1.0) if backwards else (1.0,)),
                  (1, 'ω', 'rad/s', 'max_angular_velocity', (1.0, -1.0)))]
    path = plane('path', [Trace(REFERENCE, 0, 'waypoints', Line(*plan.waypoints.T)),
                          *_coloured(plan.pose[:, 0], plan.pose[:, 1], plan), *backwards], poses)
    caption = 'Coloured by the limit that is active there' + (
        '; triangles: the robot at the start and in each stretch and turn.' if poses else '.')
    motion = Figure('motion', 'Path and speed', caption, names, (path, *speeds), 6.0, 11.0,
                    [['path', 'v'], ['path', 'ω']])
    torque = timing['torque_fraction'] * timing['max_wheel_torque']
    wheels = [Panel(label, label, unit, (
        *_limits(plan, limit, (1.0, -1.0)),
        *(Trace(VALUE, side, '', Line(plan.time, values[:, side])) for side in (0, 1))))
              for label, unit, values, limit in (
                  ('wheel speed', 'rad/s', plan.wheel_velocity, timing['max_wheel_velocity']),
                  ('wheel torque', 'N m', plan.wheel_torque, torque))]
    return [motion, Figure('wheels', 'Wheels', 'Torques are those of the timed reference, without corrections.',
                           ('right', 'left'), tuple(wheels), 5.0, 11.0)]


def _pictures(plan: Plan) -> list[str]:
    """Return a plan as a sentence and its pictures, as HTML."""
    repeated = f'; {plan.repeated} repeated ones are left out' if plan.repeated else ''
    ignored = [f'<p>{escape(words.capitalize())}.</p>' for words in plan.ignored]
    return [f'<p>{plan.length:.3g} m in {plan.duration:.4g} s, at {len(plan.time)} points. The {len(plan.waypoints)} '
            f'waypoints are within {round(100.0 * plan.deviation, 4):.2g} cm of the path{repeated}.</p>', *ignored, *(
        page.picture(figure.title, figure.caption, page.drawing(as_svg(draw(figure))), name=f'plan-{figure.name}')
        for figure in plan_figures(plan))]


def plans_of_runs(runs: Sequence[Run]) -> list[str]:
    """Return the plans of the initial paths of runs, each once, as HTML."""
    by_path: dict[PathRequest, tuple[Configuration, list[str]]] = {}
    for run in runs:
        cart = run.parameters.reference_cart if run.parameters else None
        path = () if cart is None or awaits_path(cart) else path_of(cart)
        if path and run.parameters:
            by_path.setdefault(path, (run.parameters, []))[1].append(run.name)
    return [part for configuration, names in by_path.values() for part in (
        *([f'<h3>{escape(", ".join(names))}</h3>'] if len(runs) > 1 else []), *_pictures(plan_of(configuration)))]


def plan_page(plan: Plan, title: str) -> str:
    """Return the page of a plan."""
    rows = [(name or 'none', f'{share:.1%}') for name, share in plan.active.items()]
    limits = [(name, f'{value:g}') for name, value in plan.limits.items() if value]
    parts = [
        f'<h1>{escape(title)}</h1>', *_pictures(plan),
        page.section('limits', 'Limits', page.html_table(('active limit', 'share of the time'), rows),
                     page.html_table(('timing', 'value in SI units'), limits)),
        page.section('made', 'How it was made', page.made_with(plan.provenance)),
    ]
    return page.page(title, parts)
