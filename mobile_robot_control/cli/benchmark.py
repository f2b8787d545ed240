"""
The command `benchmark`: compare laws, each searched with one budget and judged in scenarios that no search saw.

Add `--budgets 25 --scenarios 1 --runs 2` to try it.

For example:
  benchmark --laws kanayama ramsete lqr --tracks on_curve published --seed 1 --output runs/benchmark
  benchmark --law test/plugins/klancar.py --laws klancar ramsete --tracks published --output runs/mine

Files written to DIR:
  benchmark.html  ranks on each track, a sortable table, paths and errors, failures, gains
  benchmark.json, benchmark.csv
                  the same numbers (docs/metrics.md#benchmarkjson)
  cells           a file for each finished law, track and seed, from which --resume goes on

Exit codes of --verify: 0 all repeated runs agree within 1e-9, 1 one differs.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from mobile_robot_control.api.benchmark_files import CELLS, BenchmarkFiles, benchmark_into_files
from mobile_robot_control.cli.command_parser import make_parser, request_of
from mobile_robot_control.cli.main import make_main
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.system.supervisor import leave_dds
from mobile_robot_control.tuning.benchmark import Benchmark, BenchmarkRequest

_DRAWN = 12


def parser() -> argparse.ArgumentParser:
    """Make the parser of `benchmark`."""
    return make_parser('benchmark', __doc__, BenchmarkRequest, BenchmarkFiles)


def _run(options: argparse.Namespace) -> int:
    request, files = request_of(BenchmarkRequest, options), request_of(BenchmarkFiles, options)
    return _verify(request, files) if files.verify else benchmark_into_files(request, files, options.command_line)


def _verify(request: BenchmarkRequest, files: BenchmarkFiles) -> int:
    """Repeat drawn runs over DDS; return the exit code."""
    benchmark, folder = Benchmark(request), Path(files.output)
    done = benchmark.held(folder / CELLS)
    if not done:
        raise ParameterError([f'{folder}: holds no benchmark with these options; run it first, without --verify'])
    # imported late: no other use needs ROS 2
    from mobile_robot_control.experiment.verifying import verify  # noqa: PLC0415
    from mobile_robot_control.ros.services.stop import Stop  # noqa: PLC0415

    differing = verify(benchmark, done, folder, _DRAWN, Stop())
    for text in differing:
        print(f'benchmark: {text}', file=sys.stderr)
    return 1 if differing else 0


_main = make_main(parser, _run)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code, also where to leave DDS hangs."""
    return leave_dds(int(_main(arguments)))


if __name__ == '__main__':
    sys.exit(main())
