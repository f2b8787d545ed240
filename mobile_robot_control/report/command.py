"""
The command `report`: measure and draw one recorded run, or several side by side.

It reads bags of other robots, too: odometry and reference are enough (docs/usage.md#read-a-bag-of-another-robot).
`--robot`, `--params-file` and `-p` stand in for the parameters of a run that has none beside it. Runs named
`real` and `simulated` are brought to one time base and compared. `--path` judges drives by a path, also those of
another stack, and compares repetitions (docs/usage.md#judge-a-drive-by-its-path).

For example:
  mrc simulate --duration 16 --params-file config/fuzzy.yaml --output run.csv
  mrc simulate --duration 16 --params-file config/backstepping.yaml --output other.csv
  mrc report run.csv --output out
  mrc report fuzzy=run.csv backstepping=other.csv --output both --animation
  mrc report dwb=runs/dwb_1,runs/dwb_2 mppi=runs/mppi_1,runs/mppi_2 --path /plan --output compared

Files written to DIR:
  report.html  one self-contained page (docs/usage.md#read-a-report)
  report.json  metrics and problems (docs/metrics.md#reportjson)
  figures/     the figures as PNG and SVG

Exit codes:
  0  done
  1  one of several runs cannot be read, or the report failed
  2  no run can be read, or bad usage
"""

import argparse
import sys
from pathlib import Path

from mobile_robot_control.cli import make_main, make_parser, request_of
from mobile_robot_control.report.request import ReportRequest, report
from mobile_robot_control.runs.bag import topic_names
from mobile_robot_control.runs.run_files import name_of
from mobile_robot_control.system.texts import printable


def parser() -> argparse.ArgumentParser:
    """Make the parser of `report`."""
    return make_parser('report', __doc__, ReportRequest, positional=('runs',))


def _run(options: argparse.Namespace) -> int:
    request = request_of(ReportRequest, options)
    assumed = request.sources.configuration(request.namespace) if request.sources.are_given else None
    output = Path(request.output)
    unreadable = report(
        [name_of(text) for text in request.runs], output, options.command_line, request.namespace, assumed,
        request.animation, topics=topic_names(request.topic), by_path=request.by_path,
    )
    print(f'report: {printable(str((output / "report.html").resolve()))}')
    return 1 if unreadable else 0


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
