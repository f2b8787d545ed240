"""The command `tune`: search for a controller's gains, as the chapter does."""

import argparse
import sys

from mobile_robot_control.api.search_files import SearchFiles, search_into_files
from mobile_robot_control.cli.command_parser import make_parser, request_of
from mobile_robot_control.cli.main import make_main
from mobile_robot_control.tuning.searching import SearchRequest


def parser() -> argparse.ArgumentParser:
    """Make the parser of `tune`."""
    return make_parser('tune', __doc__, SearchRequest, SearchFiles, positional=('controller',))


def _run(options: argparse.Namespace) -> int:
    return search_into_files(request_of(SearchRequest, options), request_of(SearchFiles, options),
                             options.command_line)


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
