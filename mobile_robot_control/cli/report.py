"""The command `report`: metrics and figures of one run, or of several side by side."""

import argparse
import sys
from pathlib import Path

from mobile_robot_control.cli.command_parser import make_parser, request_of
from mobile_robot_control.cli.main import make_main
from mobile_robot_control.pages.reports import ReportRequest, report
from mobile_robot_control.runs.run_files import name_of
from mobile_robot_control.runs.topic_names import topic_names
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
        request.animation, topics=topic_names(request.topic),
    )
    print(f'report: {printable(str((output / "report.html").resolve()))}')
    return 1 if unreadable else 0


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
