"""
The command `tune`: search for the gains of a controller, as the chapter does.

The method is described in docs/tuning.md. A rollout has at most 1e8 steps. 150 generations take some ten
seconds with numba; add `--generations 2` to try it. Every combination of --curves, --scales, --start,
--mass, --friction, --delays and --coulomb is a scenario; an option that is left out keeps the configured value.

For example:
  mrc tune backstepping --seed 1 --params-file config/backstepping.yaml --output my_gains.yaml

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
import sys
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.analysis.promises import brief_lines
from mobile_robot_control.cli import make_main, make_parser, request_of
from mobile_robot_control.loop.batch import TrialRunner
from mobile_robot_control.loop.workers import runner
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.search import space
from mobile_robot_control.search.gains import configured_gains
from mobile_robot_control.search.journal import Journal
from mobile_robot_control.search.objective import Objective
from mobile_robot_control.search.request import Search, SearchRequest
from mobile_robot_control.search.result import Tuned, tuned_of, write_result
from mobile_robot_control.search.search import Generation, no_result
from mobile_robot_control.search.stages import Staged
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.system.files import check_regular
from mobile_robot_control.system.process import Interrupt
from mobile_robot_control.system.progress import StagedBar
from mobile_robot_control.system.texts import answer_lines, printable


class SearchFiles(NamedTuple):
    """The files of a search."""

    output: Annotated[str, Field('', 'parameter file to write')]
    resume: Annotated[bool, Field('', 'continue an interrupted search from its journal')] = False
    overwrite: Annotated[bool, Field('', 'replace a better file or a journal')] = False


def search_into_files(request: SearchRequest, files: SearchFiles, command_line: str) -> int:
    """Search and write; return 0, or 1 without a result, after an interrupt, or if a better file stays."""
    search, output = Search(request), Path(files.output)
    check_regular(output)
    output.parent.mkdir(parents=True, exist_ok=True)
    with Interrupt() as interrupt, runner(request.where) as trials:
        objective = Objective(search.parameters, search.goal, trials)
        standing = math.inf if files.overwrite else _standing(output, objective, request.controller)
        journal = _journal(search, files)
        staged, is_lost = _searched(search, trials, journal, interrupt)
        best = staged.result
        why = '' if is_lost else no_result(best)
        if why:
            before = best.point is None and interrupt.requested
            print(f'tune: {"interrupted before the first generation was scored" if before else why}', file=sys.stderr)
        if why or best.point is None:
            return 1
        written = _write(tuned_of(search, staged, objective, command_line), files.output, standing, trials)
    if is_lost:
        return 1
    if staged.is_complete:
        journal.file.unlink(missing_ok=True)
    elif interrupt.requested:
        print(f'tune: interrupted after {len(best.history)} generations; --resume goes on', file=sys.stderr)
        return 1
    return 0 if written else 1


def _searched(search: Search, trials: TrialRunner, journal: Journal, interrupt: Interrupt) -> tuple[Staged, bool]:
    """Search with a progress bar; return the result, and whether the journal or the cluster was lost."""
    with StagedBar(search.most_generations, 'generation', 'searching') as bar:
        def progress(generation: Generation) -> None:
            bar.set_postfix_str(f'best {generation.best:.4f}, mean {generation.mean:.4g}', refresh=False)
            bar.update()

        try:
            staged = search.run(trials, journal, progress, lambda: interrupt.requested)
            # stages that were not needed
            bar.update(search.most_generations - len(staged.result.history))
            return staged, False
        except OSError as error:
            staged = error.result  # type: ignore[attr-defined]
            print(f'tune: {printable(str(error.filename or journal.file))}: {error.strerror or error}; earlier scores '
                  'are kept: fix this and continue with --resume', file=sys.stderr)
        finally:
            journal.close()
    best = staged.result
    if best.point is not None:
        gains = Objective(search.parameters, search.goal._replace(genes=staged.genes), trials).gains(
            best.point.tolist())
        print(f'tune: the best of {len(best.history)} generations has the objective {best.score:.6g}: '
              f'{space.parameters(staged.genes, gains)}', file=sys.stderr)
    return staged, True


def _standing(file: Path, objective: Objective, controller: str) -> float:
    """Return the score of the existing parameter file; infinite if there is none."""
    if not file.exists():
        return math.inf
    try:
        gains = configured_gains(configure(load([file])))
        ours = controller in (space.VELOCITY, gains.control.controller_type)
    except ParameterError:
        ours = False
    if not ours:
        raise ParameterError([f'{file}: exists and holds no {controller} controller to compare with; name another '
                              '--output, or give --overwrite'])
    return objective.score(gains)


def _journal(search: Search, files: SearchFiles) -> Journal:
    """Begin the journal of a search, or continue it; raise ParameterError if another one would be lost."""
    file = Path(f'{files.output}.journal')
    if file.exists() and not (files.resume or files.overwrite):
        raise ParameterError([f'{file}: holds a search that was not finished; --resume goes on with it, --overwrite '
                              'begins anew'])
    return Journal(file, search.purpose(), files.resume and not files.overwrite)


def _write(tuned: Tuned, output: str, standing: float, trials: TrialRunner) -> bool:
    """Write all files, unless a better one exists; return whether the best result is in them."""
    shown = printable(output)
    if standing <= tuned.objective:
        print(f'tune: {shown} has the objective {standing:.6g} and stays, {tuned.answer}; --overwrite replaces it',
              file=sys.stderr)
        return standing == tuned.objective
    holds = write_result(tuned, Path(output), trials)
    print(*answer_lines(f'{shown}: {tuned.answer}', brief_lines([holds]), str(Path(output).with_suffix('.html'))),
          sep='\n')
    return True


def parser() -> argparse.ArgumentParser:
    """Make the parser of `tune`."""
    return make_parser('tune', __doc__, SearchRequest, SearchFiles, positional=('controller',))


def _run(options: argparse.Namespace) -> int:
    return search_into_files(request_of(SearchRequest, options), request_of(SearchFiles, options),
                             options.command_line)


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
