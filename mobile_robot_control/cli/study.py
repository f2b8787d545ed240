"""
The command `study`: test controllers in the same random starts, robots, noise and delay.

A run has at most 1e8 steps. Add `--runs 20` to try it.

For example:
  study --runs 2000 --seed 1 --compare config/backstepping.yaml config/fuzzy.yaml --output runs/study

Files written to DIR:
  study.json  statistics of each controller (docs/metrics.md#studyjson)
  runs.csv    one row per run and controller, numbered from 1 (docs/metrics.md#studyjson)
  study.html  the best controller and its lead with an interval, success rates, distributions of all
              metrics, the map of the starts with the numbers of each run under the pointer, and a
              sortable table of all runs with the command that repeats each; the first 8 runs in
              which a controller fails, and 3 in the middle of those in which all succeed, replay by a
              click, unless Ctrl-C ended the study
  starts.png, starts.svg
              map of the starts; the SVG follows light and dark pages

The output says for each controller where it fails (docs/tuning.md#where-a-controller-fails) and what the
numbers hold for (docs/promises.md), then compares them (docs/tuning.md#two-controllers-compared).
"""

import argparse
import sys

from mobile_robot_control.api.study_files import StudyFiles, study_into_files
from mobile_robot_control.cli.command_parser import make_parser, request_of
from mobile_robot_control.cli.main import make_main
from mobile_robot_control.tuning.studying import StudyRequest


def parser() -> argparse.ArgumentParser:
    """Make the parser of `study`."""
    return make_parser('study', __doc__, StudyRequest, StudyFiles)


def _run(options: argparse.Namespace) -> int:
    return study_into_files(request_of(StudyRequest, options), request_of(StudyFiles, options), options.command_line)


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
