"""The scenarios in which `tune` tries every individual."""

import argparse
from collections.abc import Sequence

from mobile_robot_control.cli.options import fraction, given_values, positive, whole_number
from mobile_robot_control.model.actuators import LONGEST_DELAY
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.tuning.monte_carlo import ScenarioDistribution, draw_scenarios
from mobile_robot_control.tuning.scenarios import Scenario, configured_scenario, scenario_grid


def _start(text: str) -> Pose:
    """Read an offset of the start [m, m, rad]."""
    try:
        x, y, yaw = map(float, text.split(','))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}': write DX,DY,DYAW, such as --start=-0.2,0,0") from None
    return Pose(x, y, yaw)


def add_scenario_options(parser: argparse.ArgumentParser) -> None:
    """Declare the scenario options: every combination of what is listed is tried; the rest is as configured."""
    group = parser.add_argument_group('scenarios', 'every combination is tried; what is left out is as configured')
    group.add_argument('--curves', nargs='+', choices=CURVES, metavar='CURVE')
    group.add_argument('--scales', nargs='+', type=positive, metavar='M', help='sizes of the curves [m]')
    group.add_argument('--start', type=_start, action='append', default=[], metavar='DX,DY,DYAW', dest='starts',
                       help="offset of the robot's start from the cart's; again and again, as --start=-0.2,0,0")
    group.add_argument('--mass', nargs='+', type=positive, default=[1.0], metavar='X',
                       help="factors on the robot's mass and inertia, such as 0.8 1.2")
    group.add_argument('--friction', nargs='+', type=positive, default=[1.0], metavar='X',
                       help='factors on its friction')
    group.add_argument('--delays', nargs='+', type=whole_number(0, LONGEST_DELAY), metavar='N',
                       help='of the torques, in periods of the velocity loop, such as 1 2 for the wall clock')
    group.add_argument('--random', type=whole_number(0, 100_000), default=0, metavar='N',
                       help='so many more scenarios, drawn')
    group.add_argument('--variation', type=fraction, default=0.2, metavar='X',
                       help='largest relative change of mass and of friction in random scenarios')
    group.add_argument('--within', type=positive, default=1.0, metavar='M',
                       help="largest distance of a random start from the cart's [m]")
    group.add_argument('--scenario-seed', type=whole_number(0), default=0, metavar='N', help='of the random scenarios')


def scenarios(options: argparse.Namespace, parameters: Configuration) -> list[Scenario]:
    """Return the scenarios that the options ask for: the listed ones, then the random ones."""
    nominal = configured_scenario(parameters)
    curves: Sequence[str] = options.curves or [nominal.curve]
    scales: Sequence[float] = options.scales or [nominal.scale]
    delays: Sequence[int] = options.delays or [nominal.delay]
    # where no start is given, the robot starts with the cart, whatever the curve
    given = 'initial_pose' in given_values(options)['plant']
    starts = options.starts or [None if given else Pose(0.0, 0.0, 0.0)]
    listed = scenario_grid(nominal, curves, scales, starts, options.mass, options.friction, delays)
    spread = ScenarioDistribution(tuple(curves), tuple(scales), options.within, options.variation, nominal.noise, 0)
    drawn = draw_scenarios(spread, options.random, options.scenario_seed)
    return listed + [scenario._replace(delay=delays[n % len(delays)]) for n, scenario in enumerate(drawn)]
