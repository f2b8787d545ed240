"""Fig. 23 to 33: the simulation results of section 4."""

from collections.abc import Callable, Sequence

from matplotlib.figure import Figure as Drawn

from chapter_figures.figure import ChapterFigure
from chapter_figures.runs import (
    FUZZY_TRIFOLIUM,
    HYBRID_LEMNISCATE,
    LAP,
    ORDINARY_LEMNISCATE,
    ORDINARY_TRIFOLIUM,
    ChapterRun,
    Runs,
)
from mobile_robot_control.figures.drawing import draw
from mobile_robot_control.figures.figure import Figure, Line
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import (
    HEADING,
    POSITION,
    POWER,
    TORQUE,
    PanelOf,
    column,
    heading_error,
    over_time,
    path_panel,
)
from mobile_robot_control.runs.series import Series

_NAMES = {ORDINARY_LEMNISCATE: 'ordinary', HYBRID_LEMNISCATE: 'hybrid', FUZZY_TRIFOLIUM: 'fuzzy',
          ORDINARY_TRIFOLIUM: 'ordinary'}
_BOTH = (HYBRID_LEMNISCATE, ORDINARY_LEMNISCATE)
Draw = Callable[[Runs], Drawn]


def _named(runs: Runs, chosen: Sequence[ChapterRun], end: float = LAP) -> list[Run]:
    """Return runs up to a time [s]."""
    return [runs.measured(run)._replace(name=_NAMES[run], series=runs.measured(run).series.until(end))
            for run in chosen]


def _over_time(panels: Sequence[PanelOf], chosen: Sequence[ChapterRun], end: float = LAP) -> Draw:
    """Return the function that draws panels of some runs up to a time [s]."""
    # from before t = 0, so that the axis does not cover the first milliseconds
    span = (-0.02 * end, end)

    def drawn(runs: Runs) -> Drawn:
        figure = over_time(panels, _named(runs, chosen, end), span, 1.9 if len(panels) > 1 else 2.8)
        if figure is None:
            raise ValueError('the runs have nothing to draw')
        return draw(figure)

    return drawn


def _paths(chosen: Sequence[ChapterRun]) -> Draw:
    """Return the function that draws the path of each run."""
    def drawn(runs: Runs) -> Drawn:
        panels = tuple(path_panel([run], run.name, f'({letter}) {run.name}' if len(chosen) > 1 else '')
                       for letter, run in zip('ab', _named(runs, chosen), strict=False))
        return draw(Figure('', '', '', ('robot',), panels, 3.4 * len(chosen) if len(chosen) > 1 else 4.6))

    return drawn


def _difference(coordinate: str) -> Callable[[Series], Line]:
    """Return the function that returns reference minus robot in a coordinate [cm]."""
    def line(series: Series) -> Line:
        robot, cart = series.line('odom', coordinate), series.line('reference', coordinate)
        return Line(robot.time, 100.0 * (cart.value - robot.value))

    return line


_ERRORS = (PanelOf('error of x', 'cm', _difference('x')), PanelOf('error of y', 'cm', _difference('y')))
_ORIENTATION = (PanelOf('$e_3$', 'rad', heading_error),)
_COMMANDS = (PanelOf('v', 'm/s', column('cmd_vel', 'linear')), PanelOf('ω', 'rad/s', column('cmd_vel', 'angular')))


def _two(run: ChapterRun, other: ChapterRun) -> str:
    """Return the commands of two runs."""
    return f'{run.command()}\n{other.command()}'


_LEMNISCATE = _two(HYBRID_LEMNISCATE, ORDINARY_LEMNISCATE)
TRACKING_FIGURES = (
    ChapterFigure('23', 'Tracking a lemniscate trajectory with (a) hybrid and (b) ordinary controllers',
                  'Both end on the curve. The hybrid one stands and turns first, so the cart gets ahead and it cuts '
                  'across; the ordinary one jumps at the cart at once.', _LEMNISCATE, _paths(_BOTH)),
    ChapterFigure('24', 'X and Y coordinate errors',
                  'The ordinary error falls at once; the hybrid one grows while the robot seeks and then falls.',
                  _LEMNISCATE, _over_time(_ERRORS, _BOTH)),
    ChapterFigure('25', 'Orientation error', 'Both decay, slowly: the printed gains damp the heading little.',
                  _LEMNISCATE, _over_time(_ORIENTATION, _BOTH)),
    ChapterFigure('26a', 'Control torques of ordinary (a) and hybrid (b) backstepping controllers: (a)',
                  'A spike of thousands of newton metres in the first milliseconds, and about one after it; a '
                  'logarithmic scale shows both.', ORDINARY_LEMNISCATE.command(),
                  _over_time(TORQUE, (ORDINARY_LEMNISCATE,))),
    ChapterFigure('26b', 'Control torques of ordinary (a) and hybrid (b) backstepping controllers: (b)',
                  'No spike at all: a few newton metres at the most.', HYBRID_LEMNISCATE.command(),
                  _over_time(TORQUE, (HYBRID_LEMNISCATE,))),
    ChapterFigure('26c', 'Requested power of DC motors: (a) hybrid',
                  'Tens of watts while the robot catches up, less on the curve.', HYBRID_LEMNISCATE.command(),
                  _over_time(POWER, (HYBRID_LEMNISCATE,))),
    ChapterFigure('26d', 'Requested power of DC motors: (b) ordinary (the first second of tracking)',
                  'Tens of kilowatts for an instant, and little after it.', ORDINARY_LEMNISCATE.command(),
                  _over_time(POWER, (ORDINARY_LEMNISCATE,), 1.0)),
    ChapterFigure('27', 'Tracking the trifolium trajectory', 'The fuzzy controller stays on the curve for the whole '
                  'lap.', FUZZY_TRIFOLIUM.command(), _paths((FUZZY_TRIFOLIUM,))),
    ChapterFigure('28', 'Time history of x and y coordinates', 'The robot lies on the reference.',
                  FUZZY_TRIFOLIUM.command(), _over_time(POSITION, (FUZZY_TRIFOLIUM,))),
    ChapterFigure('29', 'Orientation of the robot', 'It follows the heading of the cart, swinging a little about it: '
                  'the law looks at the bearing, not at the heading.', FUZZY_TRIFOLIUM.command(),
                  _over_time(HEADING, (FUZZY_TRIFOLIUM,))),
    ChapterFigure('30', 'Linear (v) and angular (w) velocity outputs of fuzzy controller',
                  'Smooth from the start, inside the limits that its output values set.', FUZZY_TRIFOLIUM.command(),
                  _over_time(_COMMANDS, (FUZZY_TRIFOLIUM,))),
    ChapterFigure('31', 'Linear (v) and angular (w) velocity outputs of ordinary backstepping controller',
                  'Both start with a jump from rest to the velocities of the cart, which is what the torques of '
                  'Fig. 33 answer.', ORDINARY_TRIFOLIUM.command(), _over_time(_COMMANDS, (ORDINARY_TRIFOLIUM,))),
    ChapterFigure('32', 'Right and left wheel torques of fuzzy', 'A newton metre or so, most of it at the start.',
                  FUZZY_TRIFOLIUM.command(), _over_time(TORQUE, (FUZZY_TRIFOLIUM,))),
    ChapterFigure('33', 'Right and left wheel torques of ordinary backstepping controller (first five seconds)',
                  'Hundreds of newton metres in the first milliseconds.', ORDINARY_TRIFOLIUM.command(),
                  _over_time(TORQUE, (ORDINARY_TRIFOLIUM,), 5.0)),
)
