"""The command `tune`: search for a controller's gains, as the chapter does."""

import argparse
import shlex
import sys
from collections.abc import Sequence

from mobile_robot_control.cli.command_parser import Lazy, make_parser
from mobile_robot_control.cli.options import configuration, make_main, non_negative, positive, whole_number
from mobile_robot_control.cli.run_length import check_laps
from mobile_robot_control.cli.scenario_options import add_scenario_options
from mobile_robot_control.cli.search_run import SearchRun
from mobile_robot_control.cli.worker_options import add_worker_options, runner
from mobile_robot_control.model import plant
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.tuning.objective import COMBINATIONS, DEFAULT_SMOOTH
from mobile_robot_control.tuning.search import ALGORITHMS
from mobile_robot_control.tuning.search_space import VELOCITY, searches


def _bound(text: str) -> tuple[str, tuple[float, float]]:
    """Read NAME=LOW:HIGH."""
    name, _, interval = text.partition('=')
    low, _, high = interval.partition(':')
    try:
        return name, (float(low), float(high))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}': write NAME=LOW:HIGH, such as k1=0:5") from None


def parse_tune(arguments: Sequence[str] | None, writes: bool = True) -> argparse.Namespace:
    """Read the command line of `tune`, that of the process where it is None; `--output` is needed if it `writes`."""
    made = make_parser('tune', __doc__)
    made.add_argument('controller', choices=Lazy(searches), help="what to search: a position law's gains, and the "
                      "velocity gains with them, which 'fuzzy' keeps; or 'velocity', which keeps the position law's")
    made.add_argument('--seed', type=whole_number(0), required=True, metavar='N', help='of all chance')
    made.add_argument('--output', required=writes, metavar='FILE.yaml', help='parameter file to write; beside it go '
                      'the history (.csv), a picture (.png) and, until the search is done, its journal (.yaml.journal)')
    made.add_argument('--resume', action='store_true', help='go on from the journal')
    made.add_argument('--overwrite', action='store_true', help='replace a better file, and a journal')
    made.add_argument('--algorithm', choices=tuple(ALGORITHMS), default='genetic')
    made.add_argument('--population', type=whole_number(5, 100_000), metavar='N',
                      help="individuals; the chapter's 51 or 101, if left out")
    made.add_argument('--generations', type=whole_number(1, 10**9), default=150, metavar='N')
    made.add_argument('--time-limit', type=positive, metavar='S', help='begin no generation after this wall time [s]')
    made.add_argument('--bounds', type=_bound, action='append', default=[], metavar='NAME=LOW:HIGH',
                      help='of a gain, such as k1=0:5 or position_controller.fuzzy.b[1]=0:2; again and again')
    made.add_argument('--keep', nargs='+', action='extend', default=[], metavar='NAME',
                      help='gains that the search leaves alone, such as k1 or fuzzy.b')
    made.add_argument('--with-velocity', action='store_true',
                      help="search the velocity gains along with a law that keeps them, such as 'fuzzy'")
    made.add_argument('--combine', choices=tuple(COMBINATIONS), default='mean',
                      help='of the objective over the scenarios')
    made.add_argument('--literal-torque', action='store_true',
                      help='take max(tau) in Eq. (29) as printed, not max|tau|')
    made.add_argument('--smooth', type=non_negative, metavar='W', help='add W times the total variation per second of '
                      'the torques [N m/s] to Eq. (29), or of the speeds that the command asks for [m/s²] where the '
                      f'base is driven by velocity; {DEFAULT_SMOOTH["torque"]:g} and {DEFAULT_SMOOTH["velocity"]:g} '
                      'if left out')
    made.add_argument('--laps', type=positive, default=1.0, metavar='N', help='length of each rollout')
    add_scenario_options(made)
    add_worker_options(made)
    options = made.parse_args(arguments)
    options.command_line = _command_line(sys.argv[1:] if arguments is None else arguments)
    return options


def searched_configuration(options: argparse.Namespace) -> Configuration:
    """Return the configuration whose gains the options search for; raise ParameterError where there is none."""
    parameters = configuration(options)
    check_laps(options.laps, parameters)
    if parameters.plant.model.drive == plant.VELOCITY and (options.controller == VELOCITY or options.with_velocity):
        raise ParameterError(["plant.drive = 'velocity' has no velocity gains to search for: the base closes that loop "
                              "itself; search for those of a position law, without --with-velocity"])
    if options.controller != VELOCITY:
        control = parameters.position_controller.control._replace(controller_type=options.controller)
        parameters = parameters._replace(
            position_controller=parameters.position_controller._replace(control=control))
    return parameters


def _run(options: argparse.Namespace) -> int:
    parameters = searched_configuration(options)
    with runner(options) as run:
        return SearchRun(options, parameters, run).run()


def _command_line(arguments: Sequence[str]) -> str:
    """Return the command without what changes no result: where it ran, and after which interruptions."""
    kept = [text for text, before in zip(arguments, ('', *arguments), strict=False)
            if text.partition('=')[0] not in ('--resume', '--workers', '--scheduler')
            and before not in ('--workers', '--scheduler')]
    return shlex.join(['tune', *kept])


main = make_main('tune', parse_tune, _run)

if __name__ == '__main__':
    sys.exit(main())
