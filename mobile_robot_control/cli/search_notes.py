"""What `tune` writes of a search beside its gains: what the scores depend on, and where the gains come from."""

import argparse
from collections.abc import Mapping
from typing import Any

from mobile_robot_control import __version__
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.tuning.objective import Goal
from mobile_robot_control.tuning.search import Found, SearchSettings


def search_purpose(parameters: Configuration, goal: Goal, settings: SearchSettings) -> dict[str, Any]:
    """Return everything that the scores of a search depend on, by name."""
    kept = {name: value for name, value in settings._asdict().items() if name not in ('generations', 'seconds')}
    loop = {f'{node}.{name}': value for node, group in parameters._asdict().items()
            for name, value in flatten(group).items()}
    # a search without it depends on nothing of it, and goes on from journals that lack it
    wanted = {name: value for name, value in goal._asdict().items() if name != 'smooth' or value}
    return {'version': __version__, **kept, **wanted, **loop, **_checksums(parameters, goal)}


def _checksums(parameters: Configuration, goal: Goal) -> dict[str, str]:
    """Return checksums of the source of the law and of the curves that are searched with."""
    law = parameters.position_controller.control.controller_type
    curves = {f"source of the curve '{one.curve}'": CURVES.checksum(one.curve) for one in goal.scenarios}
    return {f"source of the law '{law}'": LAWS.checksum(law), **curves}


def search_notes(
    options: argparse.Namespace, goal: Goal, settings: SearchSettings, found: Found, metrics: Mapping[str, Any]
) -> list[str]:
    """Return where gains come from, as comments at the head of their parameter file; metrics of the configured run."""
    torque = metrics['peak_wheel_torque']
    robot = '' if options.robot is None else f' for the robot {options.robot}'
    return [
        f'{goal.controller} gains{robot} found by mobile_robot_control {__version__} with',
        f'  {options.command_line}',
        f'{settings.algorithm}, seed {settings.seed}, {len(found.history)} generations of {settings.population}, '
        f'{len(goal.scenarios)} scenario{"s" * (len(goal.scenarios) != 1)} of {goal.laps:g} laps',
        f'objective {found.score!r}: {goal.combine} of Eq. (29) with max '
        f'{"tau as printed" if goal.literal else "|tau|"}'
        + (f', and {goal.smooth:g} times the variation per second' if goal.smooth else ''),
        f'the configured run: objective {metrics["objective"]:.4f}, RMS error '
        f'{100 * metrics["rms_position_error"]:.2f} cm, largest {100 * metrics["max_position_error"]:.2f} cm'
        + (f', largest |torque| {max(torque.values()):.3f} N m' if torque else ''),
    ]
