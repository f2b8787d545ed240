"""The result of a search, which writes itself: a parameter file with its origin, the history, and a page."""

import csv
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from mobile_robot_control.analysis.promises import Promise, promise, promise_lines
from mobile_robot_control.control.velocity_law import slow_integrals
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS, selected_velocity_law
from mobile_robot_control.loop.batch import TrialRunner
from mobile_robot_control.loop.scenarios import frictions
from mobile_robot_control.loop.workers import runner
from mobile_robot_control.model.plant import VELOCITY
from mobile_robot_control.parameters.declaration import declarations, flatten
from mobile_robot_control.parameters.rcl_yaml import dump_yaml
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure, rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import SampleReader
from mobile_robot_control.search import space
from mobile_robot_control.search.gains import rounded
from mobile_robot_control.search.objective import EQ29, Better, Goal, Objective
from mobile_robot_control.search.page import search_figure, write_search_page
from mobile_robot_control.search.request import Search
from mobile_robot_control.search.search import Generation
from mobile_robot_control.search.stages import Staged
from mobile_robot_control.settings.configure import File
from mobile_robot_control.settings.nodes import Configuration, course_of
from mobile_robot_control.settings.provenance import provenance
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.texts import printable
from mobile_robot_control.version import __version__

if TYPE_CHECKING:
    from mobile_robot_control.report.inline_page import InlinePage

_ALWAYS = {
    'plant': (),
    'position_controller': ('controller_type',),
    'reference_cart': ('curve', 'scale', 'period'),
}
_SHARED = ('velocity_rate', 'position_rate', 'lockstep', 'robot.')
"""Prefixes of parameters that are written even if they equal the defaults."""


class Tuned(NamedTuple):
    """
    The result of a search.

    Attributes
    ----------
    controller : str
        Target of the search.
    objective : float
        Of the gains, over the scenarios of the search; smaller is better.
    parameters : dict of str to object
        The gains by ``NODE.PARAMETER``, for `simulate` and `study`; as configured, if those are better.
    history : tuple of Generation
        Number, best score, mean score and lost individuals of each generation.
    configuration : Configuration
        The configured loop with these gains.
    provenance : dict of str to object
        The call, versions and parameters that produced it.
    search : Search
        The request.
    better : Better
        Scores of the gains found and of those configured.
    cautions : tuple of str
        Sentences about gains at the edge of their bounds, and about slow integrals.
    confirmation : str
        How searches with other seeds ended, as a sentence; '' if there were none.
    """

    controller: str
    objective: float
    parameters: dict[str, object]
    history: tuple[Generation, ...]
    configuration: Configuration
    provenance: dict[str, Any]
    search: Search
    better: Better
    cautions: tuple[str, ...]
    confirmation: str = ''

    @property
    def answer(self) -> str:
        """Which gains are better, those found or those configured, as a sentence."""
        confirmed = f'; {self.confirmation}' if self.confirmation and not self.better.as_configured else ''
        return self.better.text(len(self.history)) + confirmed

    def __repr__(self) -> str:
        gains = ', '.join(f'{name.partition(".")[2].removeprefix(f"{self.controller}.")} = {value}'
                          for name, value in self.parameters.items() if not name.endswith('.controller_type'))
        return (f'<Tuned {self.controller}: objective {self.objective:.4g} after {len(self.history)} generations, '
                f'{gains}>')

    def save(self, file: File) -> None:
        """Write a parameter file for every node and command; an existing file is replaced."""
        write_atomically(Path(file), _text(self, [
            f'{self.controller} gains found by mobile_robot_control {__version__}',
            f'objective {self.objective!r} after {len(self.history)} generations']))

    def report(self, file: File) -> 'InlinePage':
        """
        Write the files of the command `tune`, its result beside the named parameter file.

        Returns
        -------
        InlinePage
            The page, for display in notebooks.

        Raises
        ------
        OSError
            If a file cannot be written.

        """
        # imported late: Matplotlib takes a second
        from mobile_robot_control.report.inline_page import inline  # noqa: PLC0415

        with runner(self.search.request.where) as trials:
            write_result(self, Path(file), trials)
        return inline(Path(file).with_suffix('.html'))


def tuned_of(search: Search, staged: Staged, objective: Objective, command_line: str) -> Tuned:
    """Return the result of a search that has found a point: the better of its gains and those configured."""
    best = staged.result
    assert best.point is not None  # noqa: S101 (for mypy: callers have checked)
    better = objective.better(rounded(space.decode(
        staged.genes, best.point.tolist(), objective.configured)))
    configuration = search.tuned(better.gains)
    named = {f'{node}.{name}': value for node, values in space.parameters(search.goal.genes, better.gains).items()
             for name, value in values.items()}
    edges = () if better.as_configured else tuple(
        f'{edge}: a search with other --bounds may find better gains' for edge in staged.edges)
    slow = '' if configuration.plant.model.drive == VELOCITY else slow_integrals(
        *selected_velocity_law(better.gains.velocity), configuration.plant.shared.robot)
    cautions = (*edges, *([f'slow integrals: {slow}; {_assumed(search)}'] if slow else []))
    return Tuned(
        controller=search.goal.controller, objective=better.score, parameters=named, history=best.history,
        configuration=configuration, provenance=provenance(command_line, configuration), search=search, better=better,
        cautions=cautions, confirmation=staged.confirmation)


def _assumed(search: Search) -> str:
    """Describe the frictions of a search, and the remedy against integrals that are slow on others."""
    viscous, coulomb = (f'{values[0]:.3g}' + (f' to {values[-1]:.3g}' if len(values) > 1 else '')
                        for values in frictions(search.parameters, search.goal.scenarios))
    return (f'on friction other than assumed, viscous {viscous} N m s/rad and Coulomb {coulomb} N m, errors last: '
            'search with --coulomb or smaller --bounds')


def write_result(tuned: Tuned, file: Path, trials: TrialRunner) -> Promise:
    """Write the files of the command `tune`; return the validity of the numbers."""
    # imported late: Matplotlib takes a second
    from mobile_robot_control.figures.drawing import draw_and_save  # noqa: PLC0415

    search, goal = tuned.search, tuned.search.goal
    before, after = (_tried(*one, goal) for one in (('before', search.parameters), ('after', tuned.configuration)))
    holds = promise(tuned.configuration, goal.scenarios)
    holds = holds._replace(cautions=(*holds.cautions, *tuned.cautions),
                           spread=Objective(search.parameters, goal, trials).spread(tuned.configuration))
    file.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(file, _text(tuned, [*_notes(tuned, after.metrics), *promise_lines(holds)]))
    write_atomically(file.with_suffix('.csv'), history_table(tuned.history))
    title = f'{goal.controller.replace("_", " ")}: objective {tuned.objective:.4g}'
    # a law that fails at once has moved nothing
    moved = [one for one in (before, after) if one.series.has('odom')]
    svg = draw_and_save(search_figure(title, tuned.history, moved), file.with_suffix('.png'))
    write_search_page(file.with_suffix('.html'), title, tuned.history, moved, holds,
                      'objective' if goal.objective == EQ29 else goal.objective, svg, tuned.provenance)
    return holds


def _text(tuned: Tuned, notes: Sequence[str]) -> str:
    """Return the gains as the text of a parameter file with comments at its head."""
    kept: dict[str, list[str]] = {}
    for name in tuned.parameters:
        node, _, parameter = name.partition('.')
        kept.setdefault(node, []).append(parameter)
    return parameter_file(tuned.configuration, kept, notes)


def _tried(name: str, parameters: Configuration, goal: Goal) -> Run:
    """Run the configured loop once."""
    duration = goal.laps * course_of(parameters.reference_cart).period
    reader = SampleReader()
    measured = measure(parameters, duration, reader.taking(rollout(parameters, duration)))
    return Run(name, reader.series(), (), summary(measured), parameters)


def _notes(tuned: Tuned, metrics: Mapping[str, Any]) -> Iterator[str]:
    """Yield the origin of gains as comments for their parameter file; metrics are those of the configured run."""
    goal, settings, torque = tuned.search.goal, tuned.search.settings, metrics['peak_wheel_torque']
    robot = tuned.search.request.sources.robot
    yield (f'{goal.controller} gains{"" if robot is None else f" for the robot {robot}"} found by '
           f'mobile_robot_control {__version__} with')
    # without the options that change no result: the place of the search, and its interruptions
    yield '  ' + re.sub(r' --(resume|(workers|scheduler)[ =]\S+)', '', tuned.provenance['command_line'])
    yield tuned.answer
    yield (f'{settings.algorithm}, seed {settings.seed}, {len(tuned.history)} generations of {settings.population}, '
           f'{len(goal.scenarios)} scenario{"s" * (len(goal.scenarios) != 1)} of {goal.laps:g} laps')
    yield (f'objective {tuned.objective!r}: {goal.combine} of '
           + (goal.objective if goal.objective != EQ29 else
              f'Eq. (29) with max {"tau as printed" if goal.literal else "|tau|"}')
           + (f', and {goal.smooth:g} times the variation per second' if goal.smooth else ''))
    yield (f'the configured run: objective {metrics["objective"]:.4f}, RMS error '
           f'{100 * metrics["rms_position_error"]:.2f} cm, largest {100 * metrics["max_position_error"]:.2f} cm'
           + (f', largest |torque| {max(torque.values()):.3f} N m' if torque else ''))


def _nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by dotted name as nested mappings."""
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *groups, last = name.split('.')
        branch = tree
        for group in groups:
            branch = branch.setdefault(group, {})
        branch[last] = list(value) if isinstance(value, tuple) else value
    return tree


def _differing(group: Any, kept: tuple[str, ...]) -> dict[str, Any]:
    """Return the values that differ from the defaults, and those with one of the given prefixes."""
    defaults = declarations(type(group))
    return {name: value for name, value in flatten(group).items()
            if value != defaults[name].default or name.startswith(kept)}


def parameter_file(configuration: Configuration, keep: Mapping[str, Sequence[str]], notes: Sequence[str]) -> str:
    """
    Return a configuration as the text of a parameter file that every node loads.

    Parameters
    ----------
    configuration : Configuration
        Checked.
    keep : mapping of str to sequence of str
        Parameters by node that are written even if they equal the defaults.
    notes : sequence of str
        Comments at the head of the file.
    """
    shared = _differing(configuration.plant.shared, _SHARED)
    tree: dict[str, Any] = {'/**': {'ros__parameters': _nested(shared)}}
    law, _ = selected_velocity_law(configuration.velocity_controller.control)
    always = {**_ALWAYS, 'velocity_controller': (f'{law.group}.',)}
    # gains of the velocity laws that do not run
    unread = {'velocity_controller': {one.group for one in VELOCITY_LAWS.values()} - {law.group}}
    for node, group in configuration._asdict().items():
        kept = (*always[node], *keep.get(node, ()))
        own = {name: value for name, value in _differing(group, kept).items()
               if name not in declarations(Shared) and name.partition('.')[0] not in unread.get(node, ())}
        if own:  # an empty section would be refused
            tree[f'/**/{node}'] = {'ros__parameters': _nested(own)}
    # a note may contain a path, and a path a newline
    head = ''.join(f'# {printable(note)}\n' if note else '#\n' for note in notes)
    parts = [dump_yaml({key: value}, width=1000) for key, value in tree.items()]
    return head + '\n'.join(parts)


def history_table(history: Sequence[Generation]) -> str:
    """Return the history of a search as CSV, one row a generation."""
    table = io.StringIO()
    writer = csv.writer(table, lineterminator='\n')
    writer.writerow(Generation._fields)
    writer.writerows(history)
    return table.getvalue()
