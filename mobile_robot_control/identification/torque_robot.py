"""The identification of a robot that takes wheel torques: its motors, and `model.driven` from efforts to motion."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.identification import findings
from mobile_robot_control.identification.estimation import Estimate, Model, estimate
from mobile_robot_control.identification.recorded import Commands, Recorded, RecordedMotion
from mobile_robot_control.identification.result import (
    HELD_OUT,
    Identification,
    Parameter,
    Prediction,
    errors_of,
    interval_of,
    is_narrow,
    left_out,
    prediction_of,
    rates_of,
)
from mobile_robot_control.loop.batch import compiled
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.driven import motorised_step
from mobile_robot_control.model.drivetrain import discretise_drivetrain
from mobile_robot_control.model.dynamics import PlantState, at_rest
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.model.motors import Motor, motors_at_rest
from mobile_robot_control.model.plant import TORQUE
from mobile_robot_control.model.robot import Robot, angular_inertia, linear_inertia
from mobile_robot_control.quantities import Pose, WheelTorque, WheelVelocity
from mobile_robot_control.settings.nodes import Configuration

TIME_CONSTANT = 'plant.motor.time_constant'
_NAMES = ('motor gain', TIME_CONSTANT, 'delay of torques')
_NO_MOTION = 1e-12
"""[m², rad²]: a sum of squares below it is none."""
_STEP = 1e-3
"""[s] of the grid on which the lag is computed."""
_STARTS = (0.003, 0.02, 0.1)
"""[s]"""
_SHORTEST_LAG = 2e-3
"""[s]: a shorter lag counts as none."""


def fit_motors(recordings: Sequence[Recorded], tell: Callable[[], object] = lambda: None) -> Estimate | None:
    """Fit gain, time constant [s] and delay [s], equal for both motors; None if no torques were requested."""
    usable = [one for one in recordings if one.requests and one.torques and np.ptp(one.requests.values) > 0.0]
    if not usable:
        return None
    rows = [np.isfinite(one.torques.values[1:]).all(axis=1) for one in usable if one.torques]

    def outputs(values: Floats) -> list[Floats]:
        return [_applied(one.requests, one.torques.times, *values)[known]
                for one, known in zip(usable, rows, strict=True) if one.requests and one.torques]

    measured = [one.torques.values[1:][known] for one, known in zip(usable, rows, strict=True) if one.torques]

    def left(start: float) -> float:
        modelled = outputs(np.array([1.0, start, 0.0]))
        return sum(float(((one - other) ** 2).sum()) for one, other in zip(measured, modelled, strict=True))

    model = Model(_NAMES, np.array([1.0, min(_STARTS, key=left), 0.0]), np.array([0.05, 1e-4, -0.02]),
                  np.array([20.0, 2.0, 0.5]), np.array([1e-4, 1e-4, 1e-4]), outputs)
    return estimate(model, measured, 2, tell)


def _applied(requests: Commands, times: Floats, gain: float, time_constant: float, delay: float) -> Floats:
    """Return the mean torques between times [s] of motors that follow the requests with a first-order lag."""
    from scipy.signal import lfilter  # noqa: PLC0415 (imported late: most commands do without)

    grid = np.arange(requests.times[0], times[-1] + _STEP, _STEP)
    newest = np.searchsorted(requests.times, grid + 0.5 * _STEP, side='right') - 1
    share = -np.expm1(-_STEP / time_constant)
    followed = gain * lfilter([share], [1.0, share - 1.0], requests.values[np.maximum(newest, 0)], axis=0)
    impulse = np.concatenate([np.zeros((1, 2)), np.cumsum(followed, axis=0) * _STEP])
    edges = np.append(grid, grid[-1] + _STEP)
    at = np.column_stack([np.interp(times - delay, edges, impulse[:, n]) for n in (0, 1)])
    applied: Floats = np.diff(at, axis=0) / np.diff(times)[:, None]
    return applied


def motor_parameters(estimated: Estimate) -> tuple[list[Parameter], list[Parameter]]:
    """Return the time constant, if there is one, as a parameter of the plant; gain and delay."""
    gain, lag, delay = (interval_of(name, value, deviation, unit) for name, value, deviation, unit in zip(
        estimated.names, estimated.values.tolist(), estimated.deviations.tolist(), ('', 's', 's'), strict=True))
    return [lag] if lag.low > _SHORTEST_LAG else [], [gain, delay]


MASS, INERTIA, VISCOUS, COULOMB = '/**.robot.mass', '/**.robot.inertia', '/**.robot.viscous_friction', (
    'plant.friction.coulomb')
_MOST_STEPS = 300_000
_SHORTEST = 5
"""Least messages of a segment with its own initial velocity."""
_FACTORS = (0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.5, 5.0, 10.0)
_WORTH = 12.0


class _Segment(NamedTuple):
    """Messages from `first` to `last` with all efforts between them known."""

    first: int
    last: int


class Known(NamedTuple):
    """
    A recording as input of the model.

    Attributes
    ----------
    torques : array of float, shape (steps, 2)
        Of the right and the left wheel at each step [N m].
    starts : array of float, shape (steps, 2)
        Velocities of the wheels at the first step of each segment [rad/s]; nan elsewhere.
    grid : array of float, shape (steps + 1,)
        Times of the steps [s].
    segments : list of tuple of int
        First and last message of each segment.
    motion : RecordedMotion
        Of the wheels.
    """

    torques: Floats
    starts: Floats
    grid: Floats
    segments: list[_Segment]
    motion: RecordedMotion


def _turn(torques: Floats, starts: Floats, state: Any, motors: Any, drivetrain: Any) -> Floats:
    """Return the angles of both wheels after each step [rad], shape (n + 1, 2)."""
    angles = np.zeros((torques.shape[0] + 1, 2))
    none = WheelTorque(0.0, 0.0)
    for k in range(torques.shape[0]):
        if starts[k, 0] == starts[k, 0]:  # not nan: a segment begins
            state = PlantState(state.pose, body_velocity(WheelVelocity(starts[k, 0], starts[k, 1]),
                                                         drivetrain.plant.robot), state.right_angle, state.left_angle)
        state, motors, _ = motorised_step(state, motors, WheelTorque(torques[k, 0], torques[k, 1]), none, drivetrain)
        angles[k + 1, 0], angles[k + 1, 1] = state.right_angle, state.left_angle
    return angles


@cache
def _compiled_turn() -> Callable[..., Floats]:
    return compiled(_turn)


def known(torques: Commands, wheels: RecordedMotion, until: float = np.inf) -> Known:
    """Return the segments of a recording with all efforts known, and their efforts on a grid."""
    usable = np.concatenate([[False], wheels.usable & (wheels.times[1:] < until), [False]])
    edges = np.flatnonzero(np.diff(usable.astype(int)))
    segments = [_Segment(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)
                if last - first >= _SHORTEST]
    period = float(np.median(np.diff(wheels.times)))
    begin, end = wheels.times[0], wheels.times[-1]
    step = max(period / max(1, round(period / 0.001)), (end - begin) / _MOST_STEPS)
    steps = int(np.ceil((end - begin) / step)) + 1
    grid = begin + np.arange(steps + 1) * step
    # an effort was applied up to its message
    later = np.minimum(np.searchsorted(torques.times, grid[:-1] + 0.5 * step), torques.times.size - 1)
    applied = np.nan_to_num(torques.values[later])
    starts = np.full((steps, 2), np.nan)
    for segment in segments:
        few = slice(segment.first, min(segment.first + _SHORTEST, segment.last))
        span = wheels.times[few.stop] - wheels.times[few.start]
        starts[round((wheels.times[segment.first] - begin) / step)] = wheels.moved[few].sum(axis=0) / span
    return Known(applied, starts, grid, segments, wheels)


def body_way(wheels: Floats, robot: Robot) -> Floats:
    """Return distances [m] and turns [rad] from angles of the right and the left wheel [rad], shape (n, 2)."""
    r, b = robot.wheel_radius, robot.wheel_separation
    return np.column_stack([0.5 * r * (wheels[:, 0] + wheels[:, 1]), r / b * (wheels[:, 0] - wheels[:, 1])])


def measured(recording: Known, robot: Robot) -> Floats:
    """Return distances and turns between the messages of all segments."""
    moved = body_way(recording.motion.moved, robot)
    return np.concatenate([moved[one.first:one.last] for one in recording.segments])


def robot_of(values: Mapping[str, float], configured: Robot) -> tuple[Robot, Friction]:
    """Return a robot and its friction with some parameters replaced, by name."""
    return (configured._replace(**{name.removeprefix('/**.robot.'): value for name, value in values.items()
                                   if name.startswith('/**.robot.')}), Friction(values.get(COULOMB, 0.0)))


def torque_model(recordings: Sequence[Known], start: Mapping[str, float], robot: Robot) -> Model:
    """
    Return the model of recordings, with parameters that start at `start`, and the given constants of a robot.

    The velocity at the start of each segment is unknown: its effect, which decays, is removed from the residuals.
    """
    names = tuple(start)
    values = np.array(list(start.values()))
    wanted = [measured(one, robot) for one in recordings]

    def outputs(values: Floats) -> list[Floats]:
        candidate, friction = robot_of(dict(zip(names, values.tolist(), strict=True)), robot)
        rates = (candidate.viscous_friction / linear_inertia(candidate),
                 candidate.viscous_friction / angular_inertia(candidate))
        distances = []
        for recording, target in zip(recordings, wanted, strict=True):
            drivetrain = discretise_drivetrain(
                discretise(candidate, float(recording.grid[1] - recording.grid[0])), Motor(), friction)
            turned = _compiled_turn()(recording.torques, recording.starts, at_rest(Pose(0.0, 0.0, 0.0)),
                                      motors_at_rest(), drivetrain)
            at = np.column_stack([np.interp(recording.motion.times, recording.grid, turned[:, n]) for n in (0, 1)])
            moved = np.concatenate([body_way(np.diff(at[seg.first:seg.last + 1], axis=0), robot)
                                    for seg in recording.segments])
            distances.append(_with_starts(recording, moved, target, rates))
        return distances

    return Model(names, values, np.array([_lowest(name) for name in names]), np.full(values.size, np.inf),
                 np.maximum(1e-4 * values, 1e-7), outputs)


def _lowest(name: str) -> float:
    return 1e-6 if name in (MASS, INERTIA) else 0.0


def _with_starts(recording: Known, modelled: Floats, target: Floats, rates: tuple[float, float]) -> Floats:
    """Return modelled distances with the initial velocity of each segment that fits the measurement best."""
    lengths = np.array([seg.last - seg.first for seg in recording.segments])
    firsts = np.concatenate([[0], np.cumsum(lengths)[:-1]])
    begun = np.concatenate([recording.motion.times[seg.first:seg.last] - recording.motion.times[seg.first]
                            for seg in recording.segments])
    steps = np.concatenate([np.diff(recording.motion.times[seg.first:seg.last + 1]) for seg in recording.segments])
    fitted = modelled.copy()
    for n, rate in enumerate(rates):
        # the distance due to 1 m/s or 1 rad/s at the start
        adds = np.exp(-rate * begun) * (-np.expm1(-rate * steps) / rate if rate > 1e-9 else steps)
        own = np.add.reduceat(adds * adds, firsts)
        share = np.add.reduceat(adds * (target[:, n] - modelled[:, n]), firsts) / own
        fitted[:, n] += np.repeat(share, lengths) * adds
    return fitted


def fit_torques(
    recordings: Sequence[Recorded], robot: Robot, tell: Callable[[], object] = lambda: None, until: float = np.inf,
    start: Mapping[str, float] | None = None,
) -> tuple[Estimate, list[Known]]:
    """
    Fit mass, inertia and friction to recordings with efforts; the data determine A + B, A - B, and friction.

    Parameters
    ----------
    recordings : sequence of Recorded
        With torques and wheels.
    robot : Robot
        Its wheels, `wheel_inertia` and `com_offset` are taken as given.
    tell : callable
        Called occasionally.
    until : float
        Time after which recordings are not used [s].
    start : mapping of str to float or None
        Start of the search.
    """
    cut = [known(one.torques, one.wheels, until) for one in recordings if one.torques and one.wheels]
    cut = [one for one in cut if one.segments]
    values = [measured(one, robot) for one in cut]
    estimated = estimate(torque_model(cut, start or _start(cut, values, robot, tell), robot), values, 2, tell)
    if start is None:
        begun = dict(zip(estimated.names, estimated.values.tolist(), strict=True))
        # a tenth of the wheels' mean torque
        usual = float(np.mean([np.abs(one.torques).mean() for one in cut]))
        dry = estimate(torque_model(cut, {**begun, COULOMB: 0.1 * usual}, robot), values, 2, tell)
        if estimated.cost - dry.cost > _WORTH * np.log(estimated.whitened.shape[0]):
            estimated = dry
    return estimated, cut


def _start(cut: Sequence[Known], values: Sequence[Floats], robot: Robot, tell: Callable[[], object]
           ) -> dict[str, float]:
    """Return approximate mass, inertia and viscous friction: the best of a grid, for each velocity separately."""
    best: tuple[float, dict[str, float]] = (np.inf, {})
    friction = robot.viscous_friction or 0.1 * linear_inertia(robot)
    for viscous in (0.1, 0.3, 1.0, 3.0, 10.0):
        costs = []
        for factor in _FACTORS:
            model = torque_model(cut, {MASS: factor * robot.mass, INERTIA: factor * robot.inertia,
                                       VISCOUS: viscous * friction}, robot)
            left = [target - found for target, found in zip(values, model.outputs(model.start), strict=True)]
            costs.append((np.concatenate(left) ** 2).sum(axis=0))
        # a robot that drives exactly straight ahead has no turn to explain
        sums = np.array(costs) / np.maximum((np.concatenate(values) ** 2).sum(axis=0), _NO_MOTION)
        cost = float(sums.min(axis=0).sum())
        if cost < best[0]:
            mass, inertia = (_FACTORS[n] for n in sums.argmin(axis=0))
            best = cost, {MASS: mass * robot.mass, INERTIA: inertia * robot.inertia, VISCOUS: viscous * friction}
        tell()
    return best[1]


def identify_torques(
    recordings: Sequence[Recorded], configuration: Configuration, tell: Callable[[], object]
) -> Identification:
    """Identify mass, inertia and friction from efforts and wheel motion; motors from requested torques."""
    robot = configuration.plant.shared.robot
    usable = [one for one in recordings if one.torques and one.wheels]
    estimated, whole = fit_torques(usable, robot, tell)
    parameters = [interval_of(name, value, deviation, unit) for name, value, deviation, unit in zip(
        estimated.names, estimated.values.tolist(), estimated.deviations.tolist(), ('kg', 'kg m²', 'N m s/rad', 'N m'),
        strict=False)]
    narrow = [one for one in parameters if is_narrow(one)]
    kept = [one for one in narrow if one.name != INERTIA or findings.turns(usable)]
    index = [estimated.names.index(one.name) for one in kept]
    motors = fit_motors(usable, tell)
    driven, motion = motor_parameters(motors) if motors else ([], [])
    start = dict(zip(estimated.names, estimated.values.tolist(), strict=True))
    split = float(np.mean([(1.0 - HELD_OUT) * np.ptp(one.wheels.times) + one.wheels.times[0]
                           for one in usable if one.wheels]))
    trained, _ = fit_torques(usable, robot, tell, split, start)
    values = dict(zip(trained.names, trained.values.tolist(), strict=True))
    moved = torque_model(whole, values, robot)
    predictions = [_torque_prediction(one, modelled, robot, split, name.name) for one, modelled, name in zip(
        whole, moved.outputs(moved.start), usable, strict=False)]
    notes = [f'wheel_inertia {robot.wheel_inertia} kg m², com_offset {robot.com_offset} m, radius '
             f'{robot.wheel_radius} m and separation {robot.wheel_separation} m are given: torques tell A + B and '
             'A - B, of which mass and inertia are made with these']
    wide = [left_out(one) for one in parameters if one not in narrow]
    return Identification(
        drive=TORQUE, parameters=(*kept, *driven), names=tuple(one.name for one in kept),
        covariance=estimated.covariance[np.ix_(index, index)], reported=(*_combinations(estimated, robot), *motion),
        facts=rates_of(usable[0].clocks), errors=errors_of(predictions),
        open=(*wide, *(() if COULOMB in estimated.names else ('Coulomb friction: none shows beside the viscous one',))),
        lacking=tuple(findings.missing_in_model(estimated, predictions, [])), notes=tuple(notes),
        predictions=tuple(predictions), residuals=estimated.whitened, provenance={})


def _combinations(estimated: Estimate, robot: Robot) -> list[Parameter]:
    """Return A + B and A - B of Eq. (15), which the data determine, with their intervals."""
    def of(values: Floats) -> Floats:
        candidate, _ = robot_of(dict(zip(estimated.names, values.tolist(), strict=True)), robot)
        return np.array([linear_inertia(candidate), angular_inertia(candidate)])

    here = of(estimated.values)
    slopes = np.column_stack([
        (of(estimated.values + step) - here) / step.max()
        for step in np.diag(1e-6 * np.maximum(estimated.values, 1e-9))])
    deviations = np.sqrt(np.diag(slopes @ estimated.covariance @ slopes.T))
    return [interval_of(name, value, deviation, 'kg m²') for name, value, deviation in zip(
        ('A + B', 'A - B'), here.tolist(), deviations.tolist(), strict=True)]


def _torque_prediction(
    recording: Known, modelled: Floats, robot: Robot, split: float, name: str
) -> Prediction:
    """Return the prediction of one recording; between its segments nothing is known."""
    rows = np.concatenate([np.arange(segment.first, segment.last) for segment in recording.segments])
    moved = body_way(recording.motion.moved, robot)
    filled = moved.copy()
    filled[rows] = modelled
    usable = np.zeros(moved.shape[0], bool)
    usable[rows] = True
    return prediction_of(name, recording.motion.times, moved, filled, usable, split)
