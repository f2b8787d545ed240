"""A benchmark with its files: run until it is done or interrupted, resumed, written."""

import json
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.configuration.provenance import provenance
from mobile_robot_control.pages.benchmark_page import write_benchmark_page
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.interrupt import Interrupt
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.texts import printable
from mobile_robot_control.tuning.benchmark import (
    Benchmark,
    BenchmarkRequest,
    Done,
    benchmark_table,
    benchmark_values,
    summary_lines,
)

CELLS = 'cells'
"""The folder of what is done, within that of a benchmark."""


class BenchmarkFiles(NamedTuple):
    """Where the result of a benchmark goes."""

    output: Annotated[str, Field('', 'folder for benchmark.html, benchmark.json, benchmark.csv, and for what is done '
                                 'of them (cells)')]
    resume: Annotated[bool, Field('', 'go on with what the folder holds; laws, tracks and seeds may be '
                      'added')] = False
    overwrite: Annotated[bool, Field('', 'replace a benchmark that the folder already holds')] = False
    verify: Annotated[bool, Field('', 'repeat 12 drawn runs of the benchmark in the folder, with the same options, by '
                                  'four nodes in lockstep; exit code 1 where one differs by more than 1e-9')] = False


def benchmark_into_files(request: BenchmarkRequest, files: BenchmarkFiles, command_line: str) -> int:
    """Run a benchmark and write; return 0, or 1 after an interrupt."""
    benchmark, folder = Benchmark(request), Path(files.output)
    cells = folder / CELLS
    held = [*cells.glob('*.json'), *cells.glob('*.journal')]
    if held and not (files.resume or files.overwrite):
        raise ParameterError([f'{folder}: holds a benchmark already; --resume goes on with it, --overwrite begins '
                              'anew'])
    if files.overwrite:
        for file in held:
            file.unlink()
    begun = time.monotonic()
    done = run_with_progress(benchmark, cells)
    if len(done) < len(benchmark.cells):
        print(f'benchmark: interrupted after {len(done)} of {len(benchmark.cells)} cells; --resume goes on',
              file=sys.stderr)
        return 1
    values = write_benchmark(folder, benchmark, done, provenance(command_line, None), time.monotonic() - begun)
    print(*summary_lines(values), sep='\n')
    print(f'page: {printable(str((folder / "benchmark.html").resolve()))}')
    return 0


def run_with_progress(benchmark: Benchmark, cells: Path) -> Done:
    """Run all cells with a progress bar until they are done or Ctrl-C is pressed."""
    with Interrupt() as interrupt, tqdm(
            total=benchmark.rollouts, disable=None, unit='rollout', unit_scale=True) as bar:
        return benchmark.run(cells, bar.update, lambda: interrupt.requested)


def write_benchmark(
    folder: Path, benchmark: Benchmark, done: Done, made: Mapping[str, Any], seconds: float | None = None
) -> dict[str, Any]:
    """Write `benchmark.json`, `benchmark.csv` and `benchmark.html` into a folder; return the content of the first."""
    values = benchmark_values(benchmark, done)
    pictures: dict[str, dict[str, Any]] = {}
    for cell, found in done:
        pictures.setdefault(cell.track.name, {}).setdefault(cell.law, found['drawn'])
    beside = {'seconds': seconds, 'provenance': made}
    write_atomically(folder / 'benchmark.json', json.dumps({**values, **beside}, indent=1) + '\n')
    write_atomically(folder / 'benchmark.csv', benchmark_table(values))
    write_benchmark_page(folder / 'benchmark.html', values, pictures, made)
    return values
