"""`benchmark`: a fair table of laws, whose result writes itself."""

import json
import tempfile
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from mobile_robot_control.benchmarking.cell_result import Done, DrivenPath
from mobile_robot_control.benchmarking.judged_table import NAME, judged_table, runs_table, write_judged_table
from mobile_robot_control.benchmarking.page import write_benchmark_page
from mobile_robot_control.benchmarking.request import Benchmark, BenchmarkRequest
from mobile_robot_control.benchmarking.table import COLUMNS, benchmark_table, benchmark_values
from mobile_robot_control.benchmarking.words import latex_table, summary_lines
from mobile_robot_control.parameters.requests import make_request, refuse_files, takes_fields
from mobile_robot_control.runs.run import as_dataframe
from mobile_robot_control.settings.configure import File, parameter_sources
from mobile_robot_control.settings.provenance import call_text, provenance
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.progress import StagedBar

if TYPE_CHECKING:
    from mobile_robot_control.report.inline_page import InlinePage


class Benchmarked(NamedTuple):
    """
    The result of a benchmark.

    Attributes
    ----------
    values : dict of str to object
        As `benchmark.json`, without its provenance.
    provenance : dict of str to object
        Call and versions that it was made with.
    asked : Benchmark
        What was asked for.
    done : list
        What was run, cell by cell.
    """

    values: dict[str, Any]
    provenance: dict[str, Any]
    asked: Benchmark
    done: Done

    def __repr__(self) -> str:
        return '\n'.join(['<Benchmarked:', *(f'  {line}' for line in summary_lines(self.values))]) + '>'

    @property
    def results(self) -> list[dict[str, Any]]:
        """A row for each law, track, kind of gains, seed and budget: success, numbers and values of the gains."""
        rows: list[dict[str, Any]] = self.values['results']
        return rows

    @property
    def hash(self) -> str:
        """Digits that change with tracks, seeds, gains and metrics, and with nothing else."""
        return str(self.values['hash'])

    def report(self, folder: File) -> 'InlinePage':
        """
        Write the files of the command `benchmark` into a folder, and return its page, which notebooks show.

        Raises
        ------
        OSError
            If they cannot be written.
        """
        # imported late: Matplotlib takes a second
        from mobile_robot_control.report.inline_page import inline  # noqa: PLC0415

        return inline(write_benchmark(self, Path(folder)))

    def to_dataframe(self) -> Any:
        """Return `results` as a table of pandas; raise ModuleNotFoundError where that is not installed."""
        return as_dataframe({name: [row[name] for row in self.results] for name in COLUMNS})

    @property
    def ranks(self) -> list[dict[str, Any]]:
        """A row for each track, budget and law over all seeds, the best law of a track first."""
        rows: list[dict[str, Any]] = self.values['ranks']
        return rows


def benchmarked(benchmark: Benchmark, done: Done, command_line: str) -> Benchmarked:
    """Return the result of what is done of a benchmark."""
    return Benchmarked(benchmark_values(benchmark, done), provenance(command_line, None), benchmark, done)


def write_benchmark(benchmarked: Benchmarked, folder: Path, seconds: float | None = None) -> Path:
    """
    Write the page of a benchmark with its picture, and its numbers as JSON, CSV and LaTeX, into a folder.

    Returns
    -------
    Path
        The page.
    """
    # imported late: Matplotlib takes a second
    from mobile_robot_control.benchmarking.picture import ratios_figure, save_picture  # noqa: PLC0415

    folder.mkdir(parents=True, exist_ok=True)
    paths: dict[str, dict[str, DrivenPath | None]] = {}
    for cell, result in benchmarked.done:
        if not cell.feedforward:
            paths.setdefault(cell.track.name, {}).setdefault(cell.name, result.path)
    beside = {'seconds': seconds, 'provenance': benchmarked.provenance}
    write_atomically(folder / 'benchmark.json', json.dumps({**benchmarked.values, **beside}, indent=1) + '\n')
    write_atomically(folder / 'benchmark.csv', benchmark_table(benchmarked.values))
    write_atomically(folder / 'benchmark_runs.csv', runs_table(benchmarked.done))
    write_judged_table(folder / NAME, judged_table(benchmarked.done, benchmarked.hash, benchmarked.asked.table))
    write_atomically(folder / 'benchmark.tex', latex_table(benchmarked.values))
    figure = ratios_figure(benchmarked.values)
    svg = save_picture(figure, folder / 'benchmark.pdf') if figure else ''
    write_benchmark_page(folder / 'benchmark.html', benchmarked.values, paths, svg, benchmarked.provenance)
    return folder / 'benchmark.html'


@takes_fields(BenchmarkRequest)
def benchmark(
    *files: File, tracks: Collection[File] = (), parameters: Mapping[str, object] | None = None,
    progress: bool = False, **options: object,
) -> Benchmarked:
    """
    Compare position laws, as the command `benchmark` does: the same seed gives the same table.

    Parameters
    ----------
    *files : path
        ROS 2 parameter files on top of those of the tracks; later ones win.
    parameters : mapping of str to object or None
        Values by ``NODE.PARAMETER``, which win over the files.
    progress : bool
        Whether to show a progress bar.

    Returns
    -------
    Benchmarked
        Ranks, numbers and gains.

    Raises
    ------
    ParameterError
        Naming every violation, with the remedy.
    """
    refuse_files(options)
    # without any, the default
    fields = {'tracks': [str(track) for track in tracks], **options, 'budgets': options.get('budgets') or None}
    sources = parameter_sources(files, None, parameters)
    chosen = Benchmark(make_request(BenchmarkRequest, {'sources': sources, **fields}))
    with (tempfile.TemporaryDirectory() as folder,
          StagedBar(chosen.rollouts, 'rollout', 'searching', progress) as bar):
        done = chosen.run(Path(folder), bar.update, lambda: False)
    return benchmarked(chosen, done, call_text('benchmark', *files, parameters=parameters, **fields))
