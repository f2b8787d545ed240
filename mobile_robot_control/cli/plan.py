"""The command `plan`: the fastest motion along a path of waypoints, as a table, numbers and a page."""

import argparse
import csv
import io
import json
import sys
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.analysis.planning import Plan, PlanRequest, make_plan
from mobile_robot_control.cli.command_parser import make_parser, request_of
from mobile_robot_control.cli.main import make_main
from mobile_robot_control.pages.plan_page import plan_page
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.texts import printable

COLUMNS = ('time', 'x', 'y', 'heading', 'v', 'omega', 'limit')


class _Files(NamedTuple):
    """Where the plan goes."""

    output: Annotated[str, Field('', 'folder for plan.csv, plan.json and plan.html')]


def parser() -> argparse.ArgumentParser:
    """Make the parser of `plan`."""
    return make_parser('plan', __doc__, PlanRequest, _Files, positional=('file',))


def _table(plan: Plan) -> str:
    """Return a plan as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(COLUMNS)
    for time, pose, velocity, limit in zip(plan.time.tolist(), plan.pose.tolist(), plan.velocity.tolist(), plan.limit,
                                           strict=True):
        writer.writerow([time, *pose, *velocity, limit])
    return text.getvalue()


def _run(options: argparse.Namespace) -> int:
    request, output = request_of(PlanRequest, options), Path(request_of(_Files, options).output)
    plan = make_plan(request, options.command_line)
    output.mkdir(parents=True, exist_ok=True)
    numbers = {'duration': plan.duration, 'length': plan.length, 'points': len(plan.time), 'limits': plan.limits,
               'active': plan.active, 'provenance': plan.provenance}
    for name, content in (('plan.csv', _table(plan)), ('plan.json', json.dumps(numbers, indent=2) + '\n'),
                          ('plan.html', plan_page(plan, f'Plan of {Path(request.file).name}'))):
        write_atomically(output / name, content)
    print(f'{plan.length:.4g} m in {plan.duration:.4g} s: {printable(str((output / "plan.html").resolve()))}')
    return 0


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
