"""The model of a robot that takes velocities: `model.base`, from recorded commands to odometry's increments."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.identification.estimation import Model
from mobile_robot_control.identification.recorded import Commands, Recorded
from mobile_robot_control.loop.batch import compiled
from mobile_robot_control.model.base import Base, base_at_rest, base_step, discretise_base
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose

STEP, COARSE_STEP = 1_000_000, 4_000_000
"""Period of a simulation [ns], and of one that only seeks a start; longer for recordings with more steps than ..."""
_MOST_STEPS = 300_000
LAGS, DELAYS = ('base.lag[0]', 'base.lag[1]'), ('delay[0]', 'delay[1]')
GAINS = ('base.wheel_gain[0]', 'base.wheel_gain[1]', 'base.turn_gain')
SECOND_LAGS = ('second lag[0]', 'second lag[1]')
"""Of the response behind the first ones; the plant has none."""
DEAD_ZONES = ('base.dead_zone[0]', 'base.dead_zone[1]')
QUANTA = ('base.quantum[0]', 'base.quantum[1]')
_BOUNDS = {'base.lag': (1e-3, 3.0, 5e-4), 'second lag': (1e-3, 3.0, 5e-4), 'delay': (-0.2, 1.5, 1e-3),
           'base.wheel_gain': (0.5, 1.5, 1e-4), 'base.turn_gain': (0.1, 1.5, 1e-4),
           'base.max_speed': (1e-3, 50.0, 1e-3), 'base.max_acceleration': (1e-3, 500.0, 2e-3),
           'base.max_deceleration': (1e-3, 500.0, 2e-3)}
"""Lower and upper bound of a parameter, and the step of its differences."""


def _drive(commands: Floats, base: Any, state: Any, base_state: Any) -> Floats:
    """Return distance [m] and turn [rad] since the start after each step of a base, shape (n + 1, 2)."""
    way = np.zeros((commands.shape[0] + 1, 2))
    rim = 0.5 * base.robot.wheel_radius
    across = base.robot.wheel_radius / base.robot.wheel_separation
    for k in range(commands.shape[0]):
        state, base_state = base_step(state, base_state, BodyVelocity(commands[k, 0], commands[k, 1]), k, base)
        way[k + 1, 0] = rim * (state.right_angle + state.left_angle)
        way[k + 1, 1] = across * (state.right_angle - state.left_angle)
    return way


@cache
def _compiled_drive() -> Callable[..., Floats]:
    return compiled(_drive)


def _period(seconds: float, step: int) -> int:
    """Return the step of the simulation of a recording of this length [ns]."""
    return max(step, int(np.ceil(seconds * 1e9 / _MOST_STEPS / 1e5)) * 100_000)


def held(commands: Commands, begin: float, steps: int, period: int, timeout: float) -> Floats:
    """Return the newest command at each step, shape (steps, 2); zero after a timeout, and before the first one."""
    times = begin + np.arange(steps) * period / 1e9
    # a command acts from the first step whose middle is not before it
    newest = np.searchsorted(commands.times, times + 0.5e-9 * period, side='right') - 1
    held_commands = np.where(newest[:, None] >= 0, commands.values[np.maximum(newest, 0)], 0.0)
    if timeout > 0.0:
        held_commands[times - commands.times[np.maximum(newest, 0)] > timeout] = 0.0
    return held_commands


def base_of(values: Mapping[str, float], configured: Base) -> Base:
    """Return a base with parameters by name, such as ``base.lag[0]``; all others are off."""
    changed: Any = Base(command_timeout=configured.command_timeout)
    for name, value in values.items():
        field, _, index = name.removeprefix('base.').partition('[')
        if not index:
            changed = changed._replace(**{field: value})
        else:
            pair = list(getattr(changed, field))
            pair[int(index[0])] = value
            changed = changed._replace(**{field: tuple(pair)})
    base: Base = changed
    return base


class SimulatedWay(NamedTuple):
    """Distance [m] and turn [rad] since the start, shape (n, 2), on a grid of times [s]."""

    times: Floats
    way: Floats

    def lagging(self, lags: Sequence[float]) -> 'SimulatedWay':
        """Return it behind one more first-order lag [s] of each velocity; 0 for none."""
        from scipy.signal import lfilter  # noqa: PLC0415 (imported late: most commands do without)

        shares = [-np.expm1((self.times[0] - self.times[1]) / lag) if lag > 0.0 else 1.0 for lag in lags]
        return SimulatedWay(self.times, np.column_stack([
            lfilter([share], [1.0, share - 1.0], self.way[:, n]) for n, share in enumerate(shares)]))

    def at(self, times: Floats, delays: Sequence[float]) -> Floats:
        """Return it at times [s] of odometry, with the delay [s] of each velocity: a shift has smooth derivatives."""
        return np.column_stack([np.interp(times - delay, self.times, self.way[:, n])
                                for n, delay in enumerate(delays)])


def simulated(
    recorded: Recorded, values: Mapping[str, float], robot: Robot, configured: Base, step: int = STEP
) -> SimulatedWay:
    """
    Simulate a recording, without delays.

    Parameters
    ----------
    recorded : Recorded
        With commands and a motion.
    values : mapping of str to float
        Parameters of the base.
    robot : Robot
        Its wheel separation mixes unequal wheels.
    configured : Base
        Only its timeout of commands is used.
    step : int
        Of the simulation [ns].
    """
    assert recorded.commands  # noqa: S101 (for mypy: checked by the caller)
    assert recorded.motion  # noqa: S101 (for mypy, too)
    times, commands = recorded.motion.times, recorded.commands
    begin = min(times[0], commands.times[0])
    period = _period(times[-1] - begin, step)
    steps = int(np.ceil((times[-1] - begin) * 1e9 / period)) + 1
    base = base_of(values, configured)
    way = _compiled_drive()(
        held(commands, begin, steps, period, configured.command_timeout),
        discretise_base(base, robot, period, period, 0), at_rest(Pose(0.0, 0.0, 0.0)),
        base_at_rest(base, period, period))
    return SimulatedWay(begin + np.arange(steps + 1) * period / 1e9, way)


def base_model(
    recordings: Sequence[Recorded], start: Mapping[str, float], fixed: Mapping[str, float], robot: Robot,
    configured: Base, step: int = STEP,
) -> Model:
    """Return the model of recordings, with parameters that start at `start` and others that are fixed."""
    names = tuple(start)
    lower, upper, steps = np.array([_BOUNDS[name.partition('[')[0]] for name in names]).T

    @lru_cache(maxsize=4)
    def without_delays(values: tuple[tuple[str, float], ...]) -> list[SimulatedWay]:
        return [simulated(one, dict(values), robot, configured, step) for one in recordings]

    def outputs(values: Floats) -> list[Floats]:
        named = dict(zip(names, values.tolist(), strict=True)) | dict(fixed)
        delays, lags = ([named.pop(name, 0.0) for name in group] for group in (DELAYS, SECOND_LAGS))
        runs = without_delays(tuple(named.items()))
        if any(lags):
            runs = [one.lagging(lags) for one in runs]
        return [np.diff(found.at(one.motion.times, delays), axis=0)[one.motion.usable]
                for one, found in zip(recordings, runs, strict=True) if one.motion]

    return Model(names, np.array(list(start.values())), lower, upper, steps, outputs)
