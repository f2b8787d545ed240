"""
The command `benchmark`: compare laws, each searched with one budget and judged in scenarios that no search saw.

Add `--budgets 25 --scenarios 1 --runs 2` to try it, for a node `--node-runs 1`.

For example:
  mrc benchmark --laws kanayama ramsete lqr --tracks on_curve published --seed 1 --output runs/benchmark
  mrc benchmark --law test/plugins/klancar.py --laws klancar ramsete --tracks published --output runs/mine
  mrc benchmark --node 'mine=python examples/foreign_nodes/position_controller.py' --tracks published \
    --against docs/benchmark_table.json.gz --output runs/node

Files written to DIR:
  benchmark.html  ranks on each track, a sortable table, paths and errors, failures, gains
  benchmark.json, benchmark.csv, benchmark_runs.csv
                  the same numbers, and all judged runs (docs/metrics.md#benchmarkjson)
  benchmark_table.json.gz
                  success and error of all judged runs, for --against
  benchmark.pdf, benchmark.tex
                  picture and table of the laws over all tracks, for a paper
  cells           a file for each finished law, track and seed, from which --resume goes on
  nodes           parameters, bag and log of each run of a node that failed

Exit codes of --verify: 0 all repeated runs agree within 1e-9, 1 one differs; of --fail-if-worse: 1 a row is
worse than in the table (docs/benchmark.md#in-continuous-integration).
"""

import argparse
import shutil
import sys
import time
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.benchmarking.benchmark import Benchmarked, benchmarked, write_benchmark
from mobile_robot_control.benchmarking.cell_result import Done, check_arithmetic
from mobile_robot_control.benchmarking.judged_table import JudgedTable, judged_table
from mobile_robot_control.benchmarking.node_cell import NodeRequest
from mobile_robot_control.benchmarking.request import Benchmark, BenchmarkRequest
from mobile_robot_control.benchmarking.words import summary_lines
from mobile_robot_control.benchmarking.worse_rows import WorseRequest, read_earlier, verdict, verdict_lines
from mobile_robot_control.cli import make_dds_main, make_parser, request_of
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.system.process import Interrupt
from mobile_robot_control.system.progress import StagedBar
from mobile_robot_control.system.texts import printable

CELLS, NODES = 'cells', 'nodes'
"""The folders of what is done, and of runs of nodes that failed, within that of a benchmark."""


class BenchmarkFiles(NamedTuple):
    """Where the result of a benchmark goes."""

    output: Annotated[str, Field('', 'folder of the result, and of what is done of it (cells)')]
    resume: Annotated[bool, Field('', 'go on with what the folder holds; laws, tracks and seeds may be '
                      'added')] = False
    overwrite: Annotated[bool, Field('', 'replace a benchmark that the folder already holds')] = False
    keep_going: Annotated[bool, Field('', 'leave out files of --law that cannot be loaded, with their reasons')] = False
    verify: Annotated[bool, Field('', 'repeat 12 drawn runs of the benchmark in the folder, with the same options, by '
                                  'four nodes in lockstep; exit code 1 where one differs by more than 1e-9')] = False


def benchmark_into_files(benchmark: Benchmark, files: BenchmarkFiles, worse: WorseRequest, command_line: str) -> int:
    """Run a benchmark and write what is done; return 1 if it is not complete, or worse than asked for."""
    folder = Path(files.output)
    cells = folder / CELLS
    earlier = read_earlier(worse.fail_if_worse, benchmark) if worse.fail_if_worse else None
    held = [*cells.glob('*.json'), *cells.glob('*.journal')]
    if held and not (files.resume or files.overwrite):
        raise ParameterError([f'{folder}: holds a benchmark already; --resume goes on with it, --overwrite begins '
                              'anew'])
    if files.overwrite:
        for file in held:
            file.unlink()
        shutil.rmtree(folder / NODES, ignore_errors=True)
    for file in cells.glob('*.json'):
        check_arithmetic(file)
    begun = time.monotonic()
    done = run_with_progress(benchmark, cells)
    ended = 'interrupted'
    if benchmark.nodes and len([cell for cell, _ in done if not cell.node]) == len(benchmark.law_cells):
        # imported late: no other use needs ROS 2
        from mobile_robot_control.benchmarking.node_runs import drive_nodes  # noqa: PLC0415
        from mobile_robot_control.ros.shared.process import Stop  # noqa: PLC0415

        ended = drive_nodes(benchmark.cells, cells, folder / NODES, Stop()) or ended
        done = benchmark.held(cells)
    interrupted = len(done) < len(benchmark.cells)
    if interrupted:
        print(f'benchmark: {ended}, after {len(done)} of {len(benchmark.cells)} cells; --resume goes on',
              file=sys.stderr)
    if not done:
        return 1
    result = benchmarked(benchmark, done, command_line)
    page = write_benchmark(result, folder, time.monotonic() - begun)
    print(*summary_lines(result.values), sep='\n')
    print(f'page: {printable(str(page.resolve()))}')
    return int(interrupted or (earlier is not None and _is_worse(result, earlier, worse, files.output)))


def _is_worse(result: Benchmarked, earlier: JudgedTable, worse: WorseRequest, folder: str) -> bool:
    """Tell how a result compares with an earlier one; return whether a row is worse."""
    outcome = verdict(judged_table(result.done, result.hash), earlier, worse.margin)
    for line in verdict_lines(outcome, str(worse.fail_if_worse), folder, worse.margin):
        print(f'benchmark: {printable(line)}', file=sys.stderr)
    return bool(outcome.worse)


def run_with_progress(benchmark: Benchmark, cells: Path) -> Done:
    """Run all cells of laws with a progress bar until they are done or Ctrl-C is pressed."""
    with Interrupt() as interrupt, StagedBar(benchmark.rollouts, 'rollout', 'searching', unit_scale=True) as bar:
        return benchmark.run(cells, bar.update, lambda: interrupt.requested)


_DRAWN = 12


def parser() -> argparse.ArgumentParser:
    """Make the parser of `benchmark`."""
    return make_parser('benchmark', __doc__, BenchmarkRequest, NodeRequest, BenchmarkFiles, WorseRequest)


def _run(options: argparse.Namespace) -> int:
    request, others = request_of(BenchmarkRequest, options), request_of(NodeRequest, options)
    files = request_of(BenchmarkFiles, options)
    benchmark = Benchmark(request, others)
    if files.verify:
        return _verify(benchmark, files)
    return benchmark_into_files(benchmark, files, request_of(WorseRequest, options), options.command_line)


def _verify(benchmark: Benchmark, files: BenchmarkFiles) -> int:
    """Repeat drawn runs over DDS; return the exit code."""
    folder = Path(files.output)
    done = benchmark.held(folder / CELLS)
    if not done:
        raise ParameterError([f'{folder}: holds no benchmark with these options; run it first, without --verify'])
    # imported late: no other use needs ROS 2
    from mobile_robot_control.benchmarking.verifying import verify  # noqa: PLC0415
    from mobile_robot_control.ros.shared.process import Stop  # noqa: PLC0415

    differing = verify(benchmark, done, folder, _DRAWN, Stop())
    for text in differing:
        print(f'benchmark: {text}', file=sys.stderr)
    return 1 if differing else 0


main = make_dds_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
