"""The command `study`: Monte Carlo robustness of one or several controllers: starts, robots, noise and delay."""

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
