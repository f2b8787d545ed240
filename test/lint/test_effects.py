"""The effects that margins and promises name, and the parameters of the plant, agree."""

from fnmatch import fnmatchcase

from mobile_robot_control.analysis.modelled import EFFECTS, effect_of
from mobile_robot_control.configuration.nodes import parameter_names

# groups of the plant that model departures from the ideal robot, but for what only says when, or belongs to the node
GROUPS = ('base', 'delay', 'disturbance', 'encoders', 'friction', 'motor', 'noise', 'odometry')
NO_EFFECT = {'plant.noise.seed', 'plant.disturbance.time', 'plant.base.command_timeout'}
NAMES = {f'{node}.{name}' for node, names in parameter_names().items() for name in names}


def _absent(patterns):
    return [pattern for pattern in patterns if not any(fnmatchcase(name, pattern) for name in NAMES)]


def _without_effect(names):
    return {name for name in names
            if name.startswith(tuple(f'plant.{group}.' for group in GROUPS)) and effect_of(name) is None}


def test_every_effect_has_parameters_that_exist():
    assert not _absent(pattern for effect in EFFECTS for pattern in effect.parameters)


def test_every_parameter_of_an_imperfect_plant_is_an_effect():
    assert _without_effect(NAMES) == NO_EFFECT
