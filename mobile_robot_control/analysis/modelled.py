"""The effects of a robot that a configuration models, and those it does not."""

from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase
from types import MappingProxyType
from typing import Any, NamedTuple

from mobile_robot_control.model.plant import split_names
from mobile_robot_control.parameters.declaration import Declaration, declarations, flatten
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.nodes import Configuration

BOTH, TORQUE, VELOCITY = ('torque', 'velocity'), ('torque',), ('velocity',)


class Effect(NamedTuple):
    """
    A property of real robots that parameters can model.

    Attributes
    ----------
    phrase : str
        Its name.
    parameters : tuple of str
        Patterns of the dotted names, with their node, of its parameters; the effect is off if all of them are 0.
    drives : tuple of str
        Values of `plant.drive` with which these parameters act.
    smooth : bool
        Whether it has a linearisation, and so is included in the margins.
    unit : str
        Of its values, if the parameters have none.
    find : str
        A test for it on a robot; '' if a promise may hold without it.
    off : float
        Value of its parameters that switches it off.

    """

    phrase: str
    parameters: tuple[str, ...]
    drives: tuple[str, ...] = BOTH
    smooth: bool = False
    unit: str = ''
    find: str = ''
    off: float = 0.0


EFFECTS = (
    Effect('lag of the base', ('plant.base.lag',), VELOCITY, True,
           find='step the command and take the time to 63 % of the step'),
    Effect('dead time of the base', ('plant.base.dead_time',), VELOCITY, True,
           find='step the command and take the time until odom moves, less its latency'),
    Effect('rate at which the base takes commands', ('plant.base.command_rate',), VELOCITY, True,
           find='see its driver'),
    Effect('dead time of the motors', ('plant.delay.velocity_steps',), TORQUE, True, 'velocity periods',
           'step the torque and take the time until joint_states change'),
    Effect('lag of the motors', ('plant.motor.time_constant',), TORQUE, True,
           find='time constant of their current, from the data sheet'),
    Effect('latency of odometry', ('plant.odometry.latency',), BOTH, True,
           find='push the robot and take the time until odom moves'),
    Effect('rate of odometry', ('plant.odometry.rate',), BOTH, True, find='ros2 topic hz odom'),
    Effect('jitter of commands and odometry', ('plant.base.command_jitter', 'plant.odometry.jitter'),
           find='ros2 topic hz odom, largest less smallest interval'),
    Effect('unlike wheels', ('plant.base.wheel_gain',), VELOCITY, True, off=1.0,
           find='command 3 m straight ahead and see it turn'),
    Effect('turn lost by skidding', ('plant.base.turn_gain',), VELOCITY, True, off=1.0,
           find='command ten turns on the spot and count'),
    Effect('dead zone', ('plant.base.dead_zone',), VELOCITY, find='raise the command from zero until it moves'),
    Effect('quantisation of commands', ('plant.base.quantum',), VELOCITY),
    Effect('ticks of the encoders', ('plant.encoders.*',), BOTH, False, 'ticks'),
    Effect('drift and slip of odometry', ('plant.odometry.*',), find='drive a lap and measure where it ends'),
    Effect('Coulomb friction', ('plant.friction.*',), TORQUE),
    Effect('torque-speed line of the motors', ('plant.motor.stall_torque', 'plant.motor.no_load_speed'), TORQUE),
    Effect('limit of the torque', ('plant.max_wheel_torque', 'velocity_controller.max_wheel_torque'), TORQUE,
           find='stall torque, from the data sheet'),
    Effect('limit of the speed', ('plant.base.max_speed', 'position_controller.limits.*_velocity'),
           find='command more than it can do'),
    Effect('limit of the acceleration', (
        'plant.base.max_acceleration', 'plant.base.max_deceleration', 'position_controller.limits.*_acceleration'),
           find='command full speed from rest and take the slope of odom'),
    Effect('mass and friction beyond the nominal ones', ('plant.mass_factor', 'plant.friction_factor'), smooth=True,
           off=1.0),
    Effect('noise', ('plant.noise.pose', 'plant.noise.velocity')),
    Effect('disturbance', ('plant.disturbance.impulse', 'plant.disturbance.step'), TORQUE),
)
"""The first effect with a parameter's name counts."""
_BASE = 'plant.base.'
WALL_CLOCK = 'timing of the wall clock'


class Described(NamedTuple):
    """
    The modelled effects, and those not modelled.

    Attributes
    ----------
    modelled : dict of str to str
        Values with units by effect.
    not_modelled : tuple of str
        Effects.
    not_in_margins : tuple of str
        Modelled effects that margins leave out.
    ruled_out : tuple of str
        Effects that the robot does not have.
    unknown : dict of str to str
        Relevant effects that are neither modelled nor ruled out, each with a test for it.

    """

    modelled: dict[str, str]
    not_modelled: tuple[str, ...]
    not_in_margins: tuple[str, ...]
    ruled_out: tuple[str, ...] = ()
    unknown: Mapping[str, str] = MappingProxyType({})


def drive_of(configuration: Configuration) -> str:
    """Return the kind of command that the plant takes: 'torque' or 'velocity'."""
    return str(flatten(configuration.plant)['drive'])


def _declared(configuration: Configuration) -> dict[str, Declaration]:
    """Return every parameter by its dotted name, node first, with its value as the default."""
    return {f'{node}.{name}': one for node, group in configuration._asdict().items()
            for name, one in declarations(type(group), defaults=group).items()}


def effect_of(name: str) -> Effect | None:
    """Return the effect that a parameter models; None if it models none."""
    return next((effect for effect in EFFECTS if any(fnmatchcase(name, one) for one in effect.parameters)), None)


def _is_off(value: object, off: float) -> bool:
    return all(one == off for one in value) if isinstance(value, tuple) else value == off


def _text(value: object, units: str) -> str:
    """Return a value with its unit; for an array, each number with its own unit or all with one."""
    numbers = value if isinstance(value, tuple) else (value,)
    each = units.split(', ')
    if len(set(each)) == 1:
        return f'{" and ".join(f"{number:g}" for number in numbers)} {each[0]}'.strip()
    return ' and '.join(f'{number:g} {unit}' for number, unit in zip(numbers, each, strict=True))


def _acting(configuration: Configuration) -> Iterator[tuple[str, Declaration, Effect]]:
    """Yield the parameters that model an effect with the configured kind of plant."""
    drive = drive_of(configuration)
    for name, declaration in _declared(configuration).items():
        effect = effect_of(name)
        if effect is not None and drive in effect.drives and (drive == 'velocity' or not name.startswith(_BASE)):
            yield name, declaration, effect


def describe_model(configuration: Configuration, instead: Mapping[str, str] | None = None) -> Described:
    """
    Return the effects that a configuration models, and those it does not.

    Parameters
    ----------
    configuration : Configuration
        Checked.
    instead : mapping of str to str
        Texts by phrase of the effects that scenarios set; '' if they leave one out.

    """
    by_phrase: dict[str, list[str]] = {}
    drive = drive_of(configuration)
    for _, declaration, effect in _acting(configuration):
        if not _is_off(declaration.default, effect.off) and declaration.kind in (int, float, tuple):
            by_phrase.setdefault(effect.phrase, []).append(
                _text(declaration.default, declaration.field.unit or effect.unit))
    texts = {phrase: ', '.join(values) for phrase, values in by_phrase.items()} | dict(instead or {})
    modelled = {effect.phrase: texts[effect.phrase] for effect in EFFECTS if texts.get(effect.phrase)}
    names = split_names(configuration.plant.model.ruled_out)
    absent = [effect for effect in map(effect_of, (f'plant.{name}' for name in names)) if effect is not None]
    # a base that takes velocities contains its motors and their friction
    missing = [effect for effect in EFFECTS if effect.phrase not in modelled and effect not in absent
               and (drive != 'velocity' or effect.drives != TORQUE)]
    wall_clock = () if configuration.plant.shared.lockstep else (WALL_CLOCK,)
    return Described(modelled, (*(effect.phrase for effect in missing), *wall_clock),
                     tuple(effect.phrase for effect in EFFECTS if effect.phrase in modelled and not effect.smooth),
                     # one of an effect's parameters may be ruled out while another models it
                     tuple(dict.fromkeys(effect.phrase for effect in absent if effect.phrase not in modelled)),
                     {effect.phrase: effect.find for effect in missing if effect.find and drive in effect.drives})


def _off(declaration: Declaration) -> Any:
    """Return the value that switches a parameter's effect off."""
    if declaration.kind is tuple:
        return (0.0,) * len(declaration.default)
    return False if declaration.kind is bool else 0


def smooth_part(configuration: Configuration) -> Configuration:
    """Return a configuration without the effects that have no linearisation: noise, limits, friction that sticks."""
    values: dict[str, dict[str, Any]] = {node: {} for node in configuration._fields}
    for name, declaration in _declared(configuration).items():
        node, _, parameter = name.partition('.')
        values[node][parameter] = declaration.default
    for name, declaration, effect in _acting(configuration):
        if not effect.smooth and declaration.kind in (bool, int, float, tuple):
            node, _, parameter = name.partition('.')
            values[node][parameter] = _off(declaration)
    return configure(values)


def pattern_of(configuration: Configuration) -> int:
    """Return the position periods after which the events of commands and odometry, at their own rates, repeat."""
    rates = [one.default for name, one, _ in _acting(configuration)
             if name in ('plant.base.command_rate', 'plant.odometry.rate') and one.default]
    position_rate = configuration.plant.shared.position_rate
    for periods in range(1, 61):
        if all(abs(x - round(x)) < 1e-6 and round(x) > 0 for x in (periods * rate / position_rate for rate in rates)):
            return periods
    return 0
