"""An identified robot by the names of other stacks: the numbers that they take, and those that they cannot know."""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from mobile_robot_control.identification.result import Identification, Parameter

NAV2, ROS2_CONTROL = 'nav2', 'ros2_control'
STACKS = (NAV2, ROS2_CONTROL)
_HEADS = {
    NAV2: ['# Nav2: velocity_smoother of 1.3 (Jazzy) on; model_delay_vx and model_delay_wz of MPPI from 1.5 (Lyrical)',
           '# on. Rates, horizons, critics, footprint and costmaps are choices, not measured.'],
    ROS2_CONTROL: ['# diff_drive_controller of ros2_controllers 4 (Jazzy). Wheel names, frames, covariances and jerk',
                   '# limits are not measured; wheel_separation and wheel_radius stay as they are.']}
_DECELERATION = 'braking, or starting where braking does not show apart'


class _Line(NamedTuple):
    """
    A line of a parameter file.

    Attributes
    ----------
    name : str
        Of the parameter, after its indentation.
    values : tuple of (float or None)
        One, or the three of v along, v aside and ω; None where the recording does not tell.
    meaning : str
        With intervals.
    zero_is_none : bool
        Whether 0 stands for an effect that does not show.

    """

    name: str
    values: tuple[float | None, ...]
    meaning: str
    zero_is_none: bool = False


class _Robot:
    """The numbers of a result by short names, such as 'max_speed[0]'."""

    def __init__(self, result: Identification) -> None:
        self._known: Mapping[str, Parameter] = {
            one.name.removeprefix('plant.').removeprefix('base.'): one for one in result.parameters}

    def value(self, *names: str) -> float | None:
        """Return the first number that is known."""
        return next((float(self._known[name].value) for name in names if name in self._known), None)

    def interval(self, *names: str) -> str:
        """Return the interval of the first number that is known, in words; '' without one."""
        parameter = next((self._known[name] for name in names if name in self._known), None)
        if parameter is None or not math.isfinite(parameter.low):
            return ''
        return f'{parameter.low:.4g} to {parameter.high:.4g} {parameter.unit}'.rstrip()

    def both(self, field: str, other: str = '') -> tuple[tuple[float | None, float | None], str]:
        """Return a number of v and of ω, and their intervals."""
        names = [[f'{one}[{n}]' for one in (field, other) if one] for n in (0, 1)]
        v, omega = (self.value(*each) for each in names)
        told = [f'{axis} {text}' for axis, each in zip('vω', names, strict=True) if (text := self.interval(*each))]
        return (v, omega), ', '.join(told)


def export_text(result: Identification, stack: str) -> str:
    """
    Return a parameter file of another stack.

    Parameters
    ----------
    result : Identification
        Of a robot that takes velocity commands.
    stack : str
        One of STACKS.

    """
    robot = _Robot(result)
    parts = {NAV2: (('velocity_smoother:', '    ', _smoother), ('controller_server:', '      ', _mppi)),
             ROS2_CONTROL: (('diff_drive_controller:', '    ', _diff_drive),)}
    judged = result.judgement
    lines = [*_HEADS[stack], f'# {result.provenance["command_line"]}', f'# the model is {judged.grade}: it misses '
             f'{judged.error:.1%} of the motion; intervals of 95 %, where there are any']
    for head, indent, make in parts[stack]:
        lines += [head, '  ros__parameters:', *(['    FollowPath:'] if len(indent) > 4 else [])]
        for line in make(robot):
            lines += _written(line, indent)
    return '\n'.join(lines) + '\n'


def _written(line: _Line, indent: str) -> Iterator[str]:
    unknown = '?' if not line.zero_is_none or all(value is None for value in line.values[::2]) else '0.0'
    texts = [unknown if value is None else repr(float(f'{value:.6g}')) for value in line.values]
    value = texts[0] if len(texts) == 1 else f'[{", ".join(texts)}]'
    # a limit of 0 would hold the robot: what does not show is for the reader to fill in
    is_open = '?' in texts
    yield f'{indent}# {line.meaning}' + '; where ? stands, the recording shows none' * is_open
    yield f'{indent}{"# " * is_open}{line.name}: {value}'


def _planar(values: tuple[float | None, float | None], sign: float = 1.0) -> tuple[float | None, ...]:
    v, omega = (None if value is None else sign * value for value in values)
    return (v, 0.0, omega)


def _smoother(robot: _Robot) -> Iterator[_Line]:
    speeds, told = robot.both('max_speed')
    yield _Line('max_velocity', _planar(speeds), f'm/s, m/s, rad/s: the base goes no faster; {told}')
    yield _Line('min_velocity', _planar(speeds, -1.0), 'the same backwards, taken as equal')
    starts, told = robot.both('max_acceleration')
    yield _Line('max_accel', _planar(starts), f'm/s², m/s², rad/s²: the base speeds up no faster; {told}')
    brakes, told = robot.both('max_deceleration', 'max_acceleration')
    yield _Line('max_decel', _planar(brakes, -1.0), f'{_DECELERATION}; {told}')
    zones, told = robot.both('dead_zone')
    yield _Line('deadband_velocity', _planar(zones), f'smaller commands do not move the base; {told}', True)


def _mppi(robot: _Robot) -> Iterator[_Line]:
    for n, name in enumerate(('vx', 'wz')):
        lag, dead_time = robot.value(f'lag[{n}]'), robot.value(f'dead_time[{n}]')
        told = ', '.join(f'{word} {text}' for word in ('lag', 'dead_time') if (text := robot.interval(f'{word}[{n}]')))
        delay = None if lag is None or dead_time is None else lag + dead_time
        yield _Line(f'model_delay_{name}', (delay,), f's: lag and dead time together; {told}')


def _diff_drive(robot: _Robot) -> Iterator[_Line]:
    for name, error in (('wheel_separation_multiplier', 'odometry.separation_error'),
                        ('left_wheel_radius_multiplier', 'odometry.radius_error[1]'),
                        ('right_wheel_radius_multiplier', 'odometry.radius_error[0]')):
        value = robot.value(error)
        yield _Line(name, (None if value is None else 1.0 / (1.0 + value),),
                    f'times the one in use, 1 / (1 + {error}), with {error} {robot.interval(error)}'
                    if value is not None else 'it takes a pose from outside, ground_truth')
    for n, axis in enumerate(('linear.x', 'angular.z')):
        for name, fields in (('max_velocity', ['max_speed']), ('max_acceleration', ['max_acceleration']),
                             ('max_deceleration', ['max_deceleration', 'max_acceleration'])):
            names = [f'{field}[{n}]' for field in fields]
            value = robot.value(*names)
            sign = -1.0 if name == 'max_deceleration' else 1.0
            yield _Line(f'{axis}.{name}', (None if value is None else sign * value,),
                        robot.interval(*names) or 'no limit shows')
