"""
The command `tune`: search for the gains of a controller, as the chapter does.

The method is described in docs/tuning.md. A rollout has at most 1e8 steps. 150 generations take some ten
seconds with numba; add `--generations 2` to try it. Every combination of --curves, --scales, --start,
--mass, --friction and --delays is a scenario; an option that is left out keeps the configured value.

For example:
  tune backstepping --seed 1 --params-file config/backstepping.yaml --output my_gains.yaml

Files written:
  FILE.yaml          parameter file for every node and command: complete, so it needs no --robot; its head
                     names the command, the robot and what the numbers hold for (docs/promises.md)
  FILE.csv           one row per generation (docs/metrics.md#the-history-of-a-search)
  FILE.html          page with the gain in the objective, the spread of the error where something is
                     random, the convergence, the loop before and after, and what holds of them
  FILE.png, FILE.svg
                     picture of the search and the loops; the SVG follows light and dark pages
  FILE.yaml.journal  until the search is done

The output ends with what was modelled and what was not, the margins of both loops, and warnings where they
are thin. With exit code 1, a better file was there and stays, or the search failed.
"""

import argparse
import math
import shlex
import sys
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.analysis.promises import Promise, brief_lines, promise, promise_lines
from mobile_robot_control.cli import make_main, make_parser, request_of
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.figures.drawing import draw_and_save
from mobile_robot_control.loop.workers import TrialRunner, runner
from mobile_robot_control.parameters.declaration import Field, ParameterError, flatten
from mobile_robot_control.reference.curves import CURVES, PATH
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure, rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import SampleReader
from mobile_robot_control.search import result, space
from mobile_robot_control.search.journal import Journal
from mobile_robot_control.search.objective import Better, Goal, Objective
from mobile_robot_control.search.page import search_figure, write_search_page
from mobile_robot_control.search.request import Search, SearchRequest
from mobile_robot_control.search.search import Found, Generation, SearchSettings, no_result, run_search
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import Configuration, course_of, path_of
from mobile_robot_control.settings.provenance import provenance
from mobile_robot_control.system.files import check_regular, write_atomically
from mobile_robot_control.system.process import Interrupt
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.texts import answer_lines, printable
from mobile_robot_control.version import __version__


class SearchFiles(NamedTuple):
    """The files of a search."""

    output: Annotated[str, Field('', 'parameter file to write')]
    resume: Annotated[bool, Field('', 'continue an interrupted search from its journal')] = False
    overwrite: Annotated[bool, Field('', 'replace a better file or a journal')] = False


def search_into_files(request: SearchRequest, files: SearchFiles, command_line: str) -> int:
    """Search and write; return 0, or 1 without a result, after an interrupt, or if a better file stays."""
    search = Search(request)
    with Interrupt() as interrupt, runner(request.where) as run:
        return SearchRun(request, search, files, command_line, run, interrupt).run()


def search_purpose(parameters: Configuration, goal: Goal, settings: SearchSettings) -> dict[str, Any]:
    """Return everything that the scores of a search depend on, by name."""
    kept = {name: value for name, value in settings._asdict().items() if name not in ('generations', 'seconds')}
    loop = {f'{node}.{name}': value for node, group in parameters._asdict().items()
            for name, value in flatten(group).items()}
    # a search without `smooth` does not depend on it, and resumes journals that lack it
    wanted = {name: value for name, value in goal._asdict().items() if name != 'smooth' or value}
    return {'version': __version__, **kept, **wanted, **loop, **_checksums(parameters, goal)}


def _checksums(parameters: Configuration, goal: Goal) -> dict[str, str]:
    """Return checksums of the source of the law, and of the curves or the path in the search."""
    law, path = parameters.position_controller.control.controller_type, path_of(parameters.reference_cart)
    curves = {f"source of the curve '{one.curve}'": CURVES.checksum(one.curve)
              for one in goal.scenarios if one.curve != PATH}
    waypoints = {'waypoints': sha256(repr(path.waypoints[:2]).encode()).hexdigest()[:16]} if path else {}
    return {f"source of the law '{law}'": LAWS.checksum(law), **curves, **waypoints}


def without_place(command_line: str) -> str:
    """Return a command without the options that change no result: its place, and its interruptions."""
    words = shlex.split(command_line)
    return shlex.join(
        text for text, before in zip(words, ('', *words), strict=False)
        if text.partition('=')[0] not in ('--resume', '--workers', '--scheduler')
        and before not in ('--workers', '--scheduler'))


def search_notes(
    request: SearchRequest, command_line: str, goal: Goal, settings: SearchSettings, found: Found,
    metrics: Mapping[str, Any],
) -> list[str]:
    """Return the origin of gains as comments for their parameter file; metrics are those of the configured run."""
    torque = metrics['peak_wheel_torque']
    robot = '' if request.sources.robot is None else f' for the robot {request.sources.robot}'
    return [
        f'{goal.controller} gains{robot} found by mobile_robot_control {__version__} with',
        f'  {command_line}',
        f'{settings.algorithm}, seed {settings.seed}, {len(found.history)} generations of {settings.population}, '
        f'{len(goal.scenarios)} scenario{"s" * (len(goal.scenarios) != 1)} of {goal.laps:g} laps',
        f'objective {found.score!r}: {goal.combine} of Eq. (29) with max '
        f'{"tau as printed" if goal.literal else "|tau|"}'
        + (f', and {goal.smooth:g} times the variation per second' if goal.smooth else ''),
        f'the configured run: objective {metrics["objective"]:.4f}, RMS error '
        f'{100 * metrics["rms_position_error"]:.2f} cm, largest {100 * metrics["max_position_error"]:.2f} cm'
        + (f', largest |torque| {max(torque.values()):.3f} N m' if torque else ''),
    ]


def _standing(file: Path, objective: Objective, controller: str) -> float:
    """Return the score of the existing parameter file; infinite if there is none."""
    if not file.exists():
        return math.inf
    try:
        gains = space.configured_gains(configure(load([file])))
        ours = controller in (space.VELOCITY, gains.control.controller_type)
    except ParameterError:
        ours = False
    if not ours:
        raise ParameterError([f'{file}: exists and holds no {controller} controller to compare with; name another '
                              '--output, or give --overwrite'])
    return objective.score(gains)


class SearchRun:
    """A search, from its request to its written files."""

    def __init__(
        self, request: SearchRequest, search: Search, files: SearchFiles, command_line: str, run: TrialRunner,
        interrupt: Interrupt,
    ) -> None:
        self._request, self._search, self._files, self._command_line = request, search, files, command_line
        self._interrupt = interrupt
        self._parameters, self._goal, self._settings = search.parameters, search.goal, search.settings
        self._output, self._shown = Path(files.output), printable(files.output)
        self._objective = Objective(self._parameters, self._goal, run)
        self._journal_file = self._output.parent / f'{self._output.name}.journal'

    def run(self) -> int:
        """Search and write; return the exit code."""
        check_regular(self._output)
        self._output.parent.mkdir(parents=True, exist_ok=True)
        standing = math.inf
        if not self._files.overwrite:
            standing = _standing(self._output, self._objective, self._goal.controller)
        if self._journal_file.exists() and not (self._files.resume or self._files.overwrite):
            raise ParameterError([f'{self._journal_file}: holds a search that was not finished; --resume goes on with '
                                  'it, --overwrite begins anew'])
        journal = Journal(self._journal_file, search_purpose(self._parameters, self._goal, self._settings),
                          self._files.resume and not self._files.overwrite)
        with tqdm(total=self._settings.generations, disable=None, unit='generation') as bar:
            def progress(generation: Generation) -> None:
                bar.set_postfix_str(f'best {generation.best:.4f}, mean {generation.mean:.4g}', refresh=False)
                bar.update()

            try:
                found = run_search(self._settings, self._objective, journal, progress,
                                   lambda: self._interrupt.requested)
            except OSError as error:
                return self._lost(error, standing)
            finally:
                journal.close()
        return self._done(found, standing, self._interrupt.requested)

    def _lost(self, error: OSError, standing: float) -> int:
        """Save the results so far when the journal or the cluster is lost."""
        found: Found | None = getattr(error, 'found', None)
        print(f'tune: {printable(str(error.filename or self._journal_file))}: {error.strerror or error}; earlier '
              'scores are kept: fix this and continue with --resume', file=sys.stderr)
        if found is not None and found.point is not None:
            gains = space.parameters(self._goal.genes, self._objective.gains(found.point.tolist()))
            print(f'tune: the best of {len(found.history)} generations has the objective {found.score:.6g}: {gains}',
                  file=sys.stderr)
            self._write(found, standing)
        return 1

    def _done(self, found: Found, standing: float, interrupted: bool) -> int:
        why = no_result(found)
        if why:
            before = found.point is None and interrupted
            print(f'tune: {"interrupted before the first generation was scored" if before else why}', file=sys.stderr)
            return 1
        better = self._write(found, standing)
        generations = len(found.history)
        if generations >= self._settings.generations:
            self._journal_file.unlink(missing_ok=True)
        elif interrupted:
            print(f'tune: interrupted after {generations} of {self._settings.generations} generations; '
                  '--resume goes on', file=sys.stderr)
            return 1
        return 0 if better else 1

    def _write(self, found: Found, standing: float) -> bool:
        """Write all files, unless a better one exists."""
        assert found.point is not None  # noqa: S101 (for mypy: callers have checked)
        gains = space.rounded(self._objective.gains(found.point.tolist()))
        return self.write(self._objective.better(gains), found, standing)

    def write(self, better: Better, found: Found, standing: float) -> bool:
        """Write all files for the better gains, unless a better file exists."""
        if standing <= better.score:
            print(f'tune: {self._shown} has the objective {standing:.6g} and stays, {better.text(len(found.history))}; '
                  '--overwrite replaces it', file=sys.stderr)
            return standing == better.score
        gains, found = better.gains, found._replace(score=better.score)
        tuned = self._search.tuned(gains)
        after = tried('after', tuned, self._goal)
        named = {node: tuple(values) for node, values in space.parameters(self._goal.genes, gains).items()}
        held = promise(tuned, self._goal.scenarios)
        edges = (() if found.point is None or better.as_configured else
                 space.at_the_edge(self._goal.genes, found.point.tolist()))
        held = held._replace(cautions=(*held.cautions, *edges), spread=self._objective.spread(tuned))
        answer = better.text(len(found.history))
        notes = search_notes(self._request, without_place(self._command_line), self._goal, self._settings, found,
                             after.metrics)
        write_atomically(self._output, result.parameter_file(tuned, named, [
            *notes[:2], answer, *notes[2:], *promise_lines(held)]))
        write_atomically(self._output.with_suffix('.csv'), result.history_table(found.history))
        before = tried('before', self._parameters, self._goal)
        write_pages(self._output, self._goal, found.score, found.history, (before, after), held,
                    provenance(self._command_line, tuned))
        print(*answer_lines(f'{self._shown}: {answer}', brief_lines([held]), str(self._output.with_suffix('.html'))),
              sep='\n')
        return True


def tried(name: str, parameters: Configuration, goal: Goal) -> Run:
    """Run the configured loop once."""
    duration = goal.laps * course_of(parameters.reference_cart).period
    reader = SampleReader()
    measured = measure(parameters, duration, reader.taking(rollout(parameters, duration)))
    return Run(name, reader.series(), (), summary(measured), parameters)


def write_pages(
    file: Path, goal: Goal, score: float, history: Sequence[Generation], runs: Sequence[Run], holds: Promise,
    made: Mapping[str, Any],
) -> Path:
    """Write picture and page of a search beside its parameter file, and return the page."""
    title = f'{goal.controller.replace("_", " ")}: objective {score:.4g}'
    # a law that fails at once has moved nothing
    moved = [one for one in runs if one.series.has('odom')]
    svg = draw_and_save(search_figure(title, history, moved), file.with_suffix('.png'))
    write_search_page(file.with_suffix('.html'), title, history, moved, holds, svg, made)
    return file.with_suffix('.html')


def parser() -> argparse.ArgumentParser:
    """Make the parser of `tune`."""
    return make_parser('tune', __doc__, SearchRequest, SearchFiles, positional=('controller',))


def _run(options: argparse.Namespace) -> int:
    return search_into_files(request_of(SearchRequest, options), request_of(SearchFiles, options),
                             options.command_line)


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
