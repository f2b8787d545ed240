"""
The command `dashboard`: watch and control the robot live in a browser.

It starts the four nodes and prints the address of the page (docs/dashboard.md). Ctrl-C ends the page and the
nodes that it started. It needs the extra `dashboard`.

For example:
  mrc dashboard --params-file config/fuzzy.yaml
  mrc dashboard --attach --namespace /robot1

Exit codes:
  0  ended by Ctrl-C
  2  bad usage, a lesson with an error, a port in use, the extra is missing, or another node publishes on
     the topics of the nodes to start
"""

import argparse
import sys

from mobile_robot_control.cli import make_dds_main, make_parser, request_of
from mobile_robot_control.dashboard.request import DashboardRequest
from mobile_robot_control.dashboard.serving import serve
from mobile_robot_control.ros.shared.process import Stop


def parser() -> argparse.ArgumentParser:
    """Make the parser of `dashboard`."""
    # before all else: a signal is not lost
    stop = Stop()
    command = make_parser('dashboard', __doc__, DashboardRequest, drives=True)
    command.set_defaults(stop=stop)
    return command


def _run(options: argparse.Namespace) -> int:
    serve(request_of(DashboardRequest, options), options.stop)
    return 0


main = make_dds_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
