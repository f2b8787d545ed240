"""
The command `tune`: search for the gains of a controller, as the chapter does.

The method is described in docs/tuning.md. A rollout has at most 1e8 steps. 150 generations take some ten
seconds with numba; add `--generations 2` to try it. Every combination of --curves, --scales, --start,
--mass, --friction and --delays is a scenario; an option that is left out keeps the configured value.

For example:
  tune backstepping --seed 1 --params-file config/backstepping.yaml --output my_gains.yaml

Files written:
  FILE.yaml          parameter file for every node and command: complete, so it needs no --robot; its head
                     names the command, the robot and what the numbers hold for (docs/promises.md)
  FILE.csv           one row per generation (docs/metrics.md#the-history-of-a-search)
  FILE.html          page with the gain in the objective, the spread of the error where something is
                     random, the convergence, the loop before and after, and what holds of them
  FILE.png, FILE.svg
                     picture of the search and the loops; the SVG follows light and dark pages
  FILE.yaml.journal  until the search is done

The output ends with what was modelled and what was not, the margins of both loops, and warnings where they
are thin. With exit code 1, a better file was there and stays, or the search failed.
"""

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
