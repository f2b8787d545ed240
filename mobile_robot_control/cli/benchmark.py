"""The command `benchmark`: a fair table of laws: each searched with one budget, judged in scenarios no search saw."""

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
