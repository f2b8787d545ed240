r"""
The command `plan`: plan the fastest motion along a path of waypoints, without driving it.

The limits are the parameters `reference_cart.timing.*`; docs/paths.md describes them and the file.

For example:
  printf '0,0\n2,0\n2,1\n0,1\n' > shelves.csv
  mrc plan shelves.csv --output runs/plan -p reference_cart.path.closed:=true \
    -p reference_cart.timing.max_linear_velocity:=0.5 -p reference_cart.timing.max_wheel_torque:=0.3

Files written to DIR:
  plan.csv   `time` [s], `x`, `y` [m], `heading` [rad], `v` [m/s], `omega` [rad/s], and `limit`: the limit
             that is active from this row to the next
  plan.json  `duration` [s], `length` [m], `points`, `deviation`: the largest distance of a waypoint from the
             path [m], `ignored`: headings, columns and times that are not used, `limits`, `active`: the share of the
             duration in which each limit is active, and `provenance`
  plan.html  page with the path coloured by its active limit, speeds, and wheel speeds and torques
"""

import argparse
import csv
import io
import json
import sys
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.cli import make_main, make_parser, request_of
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.planning.page import plan_page
from mobile_robot_control.planning.planning import Plan
from mobile_robot_control.planning.request import PlanRequest, make_plan
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.texts import printable

COLUMNS = ('time', 'x', 'y', 'heading', 'v', 'omega', 'limit')


class _Files(NamedTuple):
    """Where the plan goes."""

    output: Annotated[str, Field('', 'folder for all files')]


def parser() -> argparse.ArgumentParser:
    """Make the parser of `plan`."""
    return make_parser('plan', __doc__, PlanRequest, _Files, positional=('file',))


def _table(plan: Plan) -> str:
    """Return a plan as CSV."""
    table = io.StringIO()
    writer = csv.writer(table, lineterminator='\n')
    writer.writerow(COLUMNS)
    for time, pose, velocity, limit in zip(plan.time.tolist(), plan.pose.tolist(), plan.velocity.tolist(), plan.limit,
                                           strict=True):
        writer.writerow([time, *pose, *velocity, limit])
    return table.getvalue()


def _run(options: argparse.Namespace) -> int:
    request, output = request_of(PlanRequest, options), Path(request_of(_Files, options).output)
    plan = make_plan(request, options.command_line)
    output.mkdir(parents=True, exist_ok=True)
    numbers = {'duration': plan.duration, 'length': plan.length, 'points': len(plan.time),
               'deviation': plan.deviation, 'ignored': plan.ignored, 'limits': plan.limits, 'active': plan.active,
               'provenance': plan.provenance}
    for name, content in (('plan.csv', _table(plan)), ('plan.json', json.dumps(numbers, indent=2) + '\n'),
                          ('plan.html', plan_page(plan, f'Plan of {Path(request.file).name}'))):
        write_atomically(output / name, content)
    for words in plan.ignored:
        print(printable(words), file=sys.stderr)
    print(f'{plan.length:.4g} m in {plan.duration:.4g} s: {printable(str((output / "plan.html").resolve()))}')
    return 0


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
