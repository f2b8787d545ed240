"""The identification of a robot that takes velocity commands, and of its odometry by a pose from outside."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.identification import findings, velocity_drive
from mobile_robot_control.identification.base_search import BaseFit, NothingFollowsError, fit_base
from mobile_robot_control.identification.estimation import Z95, Estimate, Model, estimate
from mobile_robot_control.identification.judgement import slip_with_curvature
from mobile_robot_control.identification.recorded import SAMPLED, Clock, Recorded, RecordedMotion, cut, moved_between
from mobile_robot_control.identification.result import (
    HELD_OUT,
    Identification,
    Parameter,
    Prediction,
    UnidentifiableError,
    errors_of,
    interval_of,
    is_narrow,
    left_out,
    prediction_of,
    rates_of,
)
from mobile_robot_control.model.base import Base
from mobile_robot_control.model.plant import VELOCITY
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.settings.nodes import Configuration

ERRORS = ('plant.odometry.radius_error[0]', 'plant.odometry.radius_error[1]', 'plant.odometry.separation_error')
_OFFSET = 'offset'
_SLIPPED = 8
"""Such distances over which the slip of a wheel is summed."""
_APART = 0.5
"""[s] between compared poses from outside: over longer distances, noise between messages matters little."""


class Alignment(NamedTuple):
    """The frame of odometry in that of the pose from outside: x, y [m], rotation [rad]."""

    x: float
    y: float
    rotation: float


def calibrate(recordings: Sequence[Recorded], robot: Robot) -> Estimate:
    """
    Estimate the errors of odometry's radii and separation, and the offset between both clocks.

    It compares motions between poses from outside, so the frames need no common origin.
    """
    seen = [_thinned(one) for one in recordings]

    def outputs(values: Floats) -> list[Floats]:
        moved = []
        for recording, true in zip(recordings, seen, strict=True):
            assert recording.motion  # noqa: S101 (for mypy: checked by the caller)
            way = np.concatenate([np.zeros((1, 2)), np.cumsum(recording.motion.moved, axis=0)])
            at = np.column_stack([np.interp(true.times - values[3], recording.motion.times, way[:, n]) for n in (0, 1)])
            moved.append(corrected(np.diff(at, axis=0), values[:3], robot))
        return moved

    model = Model((*ERRORS, _OFFSET), np.zeros(4), np.array([-0.5, -0.5, -0.5, -1.0]),
                  np.array([0.5, 0.5, 0.5, 1.0]), np.array([1e-5, 1e-5, 1e-5, 1e-3]), outputs)
    return estimate(model, [true.moved for true in seen])


def _slip(calibration: Estimate, seen: Sequence[Recorded], robot: Robot) -> Parameter:
    """
    Return the slip of the wheels by what the calibrated odometry misses over some metres.

    A slip that depends on the motion, as of a skid steer, counts as a random one of the same size.
    """
    squares: list[Floats] = []
    ways: list[Floats] = []
    for recording, left in zip(seen, calibration.residuals, strict=True):
        moved = _thinned(recording).moved
        half = 0.5 * robot.wheel_separation
        for sign in (1.0, -1.0):
            missed, way = left[:, 0] + sign * half * left[:, 1], np.abs(moved[:, 0] + sign * half * moved[:, 1])
            count = missed.size // _SLIPPED
            for values, sums in ((missed, squares), (way, ways)):
                sums.append(values[:count * _SLIPPED].reshape(count, _SLIPPED).sum(axis=1))
    missed, way = np.concatenate(squares), np.concatenate(ways)
    value = float(np.sqrt((missed**2).sum() / max(way.sum(), 1e-9)))
    # a variance from n squares
    deviation = value / np.sqrt(2.0 * max(1, missed.size))
    return interval_of('plant.odometry.slip', value, deviation, 'm/√m')


def _thinned(recording: Recorded) -> RecordedMotion:
    """Return the motion of the pose from outside, over intervals within odometry."""
    assert recording.truth  # noqa: S101 (for mypy: checked by the caller)
    assert recording.motion  # noqa: S101 (for mypy, too)
    times, way = recording.truth.times, np.concatenate(
        [np.zeros((1, 2)), np.cumsum(moved_between(recording.truth.values), axis=0)])
    inside = np.flatnonzero((times > recording.motion.times[0] + 1.0) & (times < recording.motion.times[-1] - 1.0))
    chosen = inside[np.unique(np.searchsorted(times[inside], np.arange(times[inside[0]], times[inside[-1]], _APART)))]
    return RecordedMotion(times[chosen], np.diff(way[chosen], axis=0), np.ones(chosen.size - 1, bool))


def corrected(moved: Floats, errors: Floats, robot: Robot) -> Floats:
    """Convert distances and turns of odometry to true ones, for the errors of its radii and its separation."""
    apart = robot.wheel_separation
    half = 0.5 * apart * (1.0 + errors[2])
    right = (moved[:, 0] + half * moved[:, 1]) / (1.0 + errors[0])
    left = (moved[:, 0] - half * moved[:, 1]) / (1.0 + errors[1])
    return np.column_stack([0.5 * (right + left), (right - left) / apart])


def with_true_motion(recording: Recorded, errors: Floats, robot: Robot) -> Recorded:
    """Return a recording with the motion of odometry, corrected for its errors."""
    motion = recording.motion
    assert motion  # noqa: S101 (for mypy: checked by the caller)
    moved = corrected(motion.moved, errors, robot)
    return recording._replace(motion=RecordedMotion(motion.times, moved, motion.usable))


def alignment(recording: Recorded) -> Alignment:
    """Return the planar motion from odometry's frame to that of the pose from outside, from positions on both paths."""
    odometry, truth = recording.odometry, recording.truth
    assert truth  # noqa: S101 (for mypy: checked by the caller)
    assert odometry  # noqa: S101 (for mypy, too)
    inside = (odometry.times >= truth.times[0]) & (odometry.times <= truth.times[-1])
    seen = odometry.values[inside, :2]
    true = np.column_stack([np.interp(odometry.times[inside], truth.times, truth.values[:, n]) for n in (0, 1)])
    # the argument of the sum of all products of complex numbers is the least-squares rotation
    there, here = (part[:, 0] + 1j * part[:, 1] for part in (true, seen))
    rotation = float(np.angle(((there - there.mean()) * (here - here.mean()).conj()).sum()))
    origin = there.mean() - np.exp(1j * rotation) * here.mean()
    return Alignment(float(origin.real), float(origin.imag), rotation)


_CLOCK_ERROR = (5e-5, 0.015)
"""Error of a clock offset by the fastest messages of a recording: [s], and as a share of their jitter."""
_AGED = 0.005
"""[s] from stamp to receipt: a message that is stamped when it is sent is younger."""
_WHOLE = 1e-3
"""Share of a rate by which it may miss a whole number of Hz."""
_ONE_CLOCK = ('dead_time holds the latency of odometry, too: one clock that stamps and records both, and --same-clock, '
              'tell them apart')
_NO_AGE = ('dead_time holds the latency of odometry, too: odometry is received as soon as it is stamped, so that its '
           'stamps do not tell the age of its samples')
_UNITS = {'base.lag': ('s', 's'), 'base.max_speed': ('m/s', 'rad/s'), 'base.max_acceleration': ('m/s²', 'rad/s²'),
          'base.max_deceleration': ('m/s²', 'rad/s²'), 'base.dead_zone': ('m/s', 'rad/s'),
          'base.quantum': ('m/s', 'rad/s'), 'delay': ('s', 's')}


class _OdometryPart(NamedTuple):
    """Parameters, the names and the covariance of those that are estimates, notes, and what the model lacks."""

    parameters: list[Parameter]
    names: tuple[str, ...]
    covariance: Floats
    notes: list[str]
    lacking: list[str]


def identify_base(
    recordings: Sequence[Recorded], configuration: Configuration, same_clock: bool, tell: Callable[[], object]
) -> Identification:
    """Identify a base; raise UnidentifiableError if its odometry does not follow the commands."""
    robot, configured = configuration.plant.shared.robot, configuration.plant.model.base
    usable = [one for one in recordings if one.commands and one.motion and one.motion.usable.any()]
    seen = [one for one in usable if one.truth]
    calibration = calibrate(seen, robot) if seen else None
    if calibration:
        usable = [with_true_motion(one, calibration.values[:3], robot) for one in usable]
    try:
        fit = fit_base(usable, robot, configured, tell)
    except NothingFollowsError as error:
        raise UnidentifiableError([str(error)]) from error
    estimated = _with_clock_error(fit.estimate, _clock_error(usable))
    if calibration:
        estimated = _with_calibration_error(estimated, calibration.covariance)
    clocks = _clocks(usable, same_clock)
    latency = clocks['odom'].floor if same_clock and clocks['odom'].stamped == SAMPLED else None
    every = [interval_of(name, value, deviation, _unit(name)) for name, value, deviation in zip(
        estimated.names, estimated.values.tolist(), estimated.deviations.tolist(), strict=True)]
    every += [Parameter(name, *zone, _unit(name)) for name, zone in fit.zones.items()]
    kept = [one for one in every if is_narrow(one)]
    renamed, delays = _delays(kept, latency)
    names, covariance = _estimates(estimated, fit, [one.name for one in kept])
    predictions = _predict(usable, fit, robot, configured, tell)
    odometry = _of_odometry(calibration, seen, robot)
    notes = [f'wheel separation {robot.wheel_separation} m and radius {robot.wheel_radius} m are given, not measured',
             'a command is taken to reach the robot when it reaches the recorder', *odometry.notes,
             *([] if latency is not None else [_NO_AGE if same_clock else _ONE_CLOCK]), *findings.not_seen(fit, usable)]
    return Identification(
        drive=VELOCITY, parameters=(*odometry.parameters, *renamed, *_odometry_parameters(clocks['odom'], latency)),
        names=(*odometry.names, *names), covariance=_diagonal(odometry.covariance, covariance), reported=tuple(delays),
        facts=rates_of(clocks), errors=errors_of(predictions),
        open=tuple(left_out(one) for one in every if one not in kept),
        lacking=(*odometry.lacking, *findings.second_lags(fit),
                 *findings.missing_in_model(estimated, predictions, _inputs_beside(usable))),
        notes=tuple(notes), predictions=tuple(predictions), residuals=estimated.whitened, provenance={})


def _of_odometry(calibration: Estimate | None, seen: Sequence[Recorded], robot: Robot) -> _OdometryPart:
    """Return the parameters of odometry from a pose from outside."""
    if calibration is None:
        notes = ['wheel_gain and turn_gain are those that odometry shows: where it comes from the wheels, it sees no '
                 'skidding']
        return _OdometryPart([], (), np.zeros((0, 0)), notes, [])
    frame = alignment(seen[0])
    return _OdometryPart(
        [interval_of(name, value, deviation, '') for name, value, deviation in zip(
            ERRORS, calibration.values.tolist(), calibration.deviations.tolist(), strict=False)]
        + [Parameter('plant.odometry.dead_reckoning', True, np.nan, np.nan, ''), _slip(calibration, seen, robot)],
        ERRORS, calibration.covariance[:3, :3],
        [f'the frame of odom lies at x {frame.x:.3f} m, y {frame.y:.3f} m, rotated by {frame.rotation:.3f} rad, in '
         'that of ground_truth'],
        list(slip_with_curvature([_by_odometry(one, left) for one, left in zip(
            seen, calibration.residuals, strict=True)], 'its odometry')))


def _by_odometry(recording: Recorded, left: Floats) -> Prediction:
    """Return the motion of the pose from outside beside that of calibrated odometry, which leaves a residual."""
    true = _thinned(recording)
    return prediction_of(recording.name, true.times, true.moved, true.moved - left, true.usable, np.inf)


def _estimates(estimated: Estimate, fit: BaseFit, kept: Sequence[str]) -> tuple[tuple[str, ...], Floats]:
    """Return names and covariance of the written estimates; the variance of a dead zone comes from its interval."""
    index = [n for n, name in enumerate(estimated.names) if name in kept]
    zones = {name: zone for name, zone in fit.zones.items() if name in kept}
    return (tuple(_written(name) for name in (*(estimated.names[n] for n in index), *zones)), _diagonal(
        estimated.covariance[np.ix_(index, index)],
        np.diag([((high - low) / (2.0 * Z95)) ** 2 for _, low, high in zones.values()])))


def _unit(name: str) -> str:
    field, _, index = name.partition('[')
    return _UNITS[field][int(index[0])] if field in _UNITS else ''


def _written(name: str) -> str:
    """Return the plant's parameter for a name in the model."""
    return f'plant.{name.replace("delay", "base.dead_time")}'


def _clock_error(recordings: Sequence[Recorded]) -> float:
    """Return the alignment error of the clocks of commands and odometry [s]."""
    jitters = [clock.jitter for one in recordings for topic, clock in one.clocks.items() if topic in (
        'odom', 'cmd_vel')]
    return max(_CLOCK_ERROR[0], _CLOCK_ERROR[1] * max(jitters)) if any(jitters) else 0.0


def _with_clock_error(estimated: Estimate, deviation: float) -> Estimate:
    """Add a common clock error to the delays of an estimate [s]."""
    shared = np.array([deviation if name.startswith('delay') else 0.0 for name in estimated.names])
    return estimated._replace(covariance=estimated.covariance + np.outer(shared, shared))


def _with_calibration_error(estimated: Estimate, calibration: Floats) -> Estimate:
    """Add the common errors of radii and separation, by which the motion was corrected, to the gains of an estimate."""
    slopes = np.zeros((len(estimated.names), 3))
    for name, error, sign in zip(velocity_drive.GAINS, range(3), (-1.0, -1.0, 1.0), strict=True):
        if name in estimated.names:
            slopes[estimated.names.index(name), error] = sign
    return estimated._replace(covariance=estimated.covariance + slopes @ calibration[:3, :3] @ slopes.T)


def _clocks(recordings: Sequence[Recorded], same_clock: bool) -> dict[str, Clock]:
    """Return the clocks of the first recording, with the mean age of odometry; an aged one was not stamped late."""
    clocks = recordings[0].clocks
    odom = clocks['odom']._replace(floor=max(0.0, float(np.mean([one.clocks['odom'].floor for one in recordings]))))
    aged = same_clock and odom.floor > _AGED
    return {**clocks, 'odom': odom._replace(stamped=SAMPLED) if aged else odom}


def _delays(kept: Sequence[Parameter], latency: float | None) -> tuple[list[Parameter], list[Parameter]]:
    """Return parameters of the plant from those of the model, and the measured delays."""
    renamed, reported = [], []
    for parameter in kept:
        if parameter.name.startswith('delay'):
            name = f'{"v" if parameter.name.endswith("[0]") else "ω"}: dead time with latency of odometry'
            reported.append(parameter._replace(name=name))
            shift = latency or 0.0
            value, low, high = (max(0.0, bound - shift) for bound in (parameter.value, parameter.low, parameter.high))
            renamed.append(Parameter(_written(parameter.name), value, low, high, parameter.unit))
        else:
            renamed.append(parameter._replace(name=_written(parameter.name)))
    return renamed, reported


def _odometry_parameters(clock: Clock, latency: float | None) -> list[Parameter]:
    """Return rate, jitter and, if known, latency of odometry; they have no intervals."""
    # a driver counts in whole Hz, and the clock of a recording has an error
    whole = round(clock.rate)
    rate = whole if abs(clock.rate - whole) < _WHOLE * clock.rate else round(clock.rate, 2)
    parameters = [Parameter('plant.odometry.rate', rate, np.nan, np.nan, 'Hz')]
    if clock.jitter > 1e-3:
        parameters.append(Parameter('plant.odometry.jitter', round(clock.jitter, 4), np.nan, np.nan, 's'))
    if latency is not None:
        parameters.append(Parameter('plant.odometry.latency', round(latency, 4), np.nan, np.nan, 's'))
    return parameters


def _diagonal(first: Floats, second: Floats) -> Floats:
    """Return the covariance of two independent groups of estimates."""
    covariance = np.zeros((len(first) + len(second),) * 2)
    covariance[:len(first), :len(first)] = first
    covariance[len(first):, len(first):] = second.reshape(len(second), len(second))
    return covariance


def _inputs_beside(recordings: Sequence[Recorded]) -> list[tuple[str, Floats]]:
    """Return the commands at the times of the residuals."""
    rows = []
    for recording in recordings:
        assert recording.commands  # noqa: S101 (for mypy: checked by the caller)
        assert recording.motion  # noqa: S101 (for mypy, too)
        at = np.searchsorted(recording.commands.times, recording.motion.times[1:], side='right') - 1
        rows.append(recording.commands.values[np.maximum(at, 0)][recording.motion.usable])
    return [('the command', np.concatenate(rows))]


def _predict(
    recordings: Sequence[Recorded], fit: BaseFit, robot: Robot, configured: Base, tell: Callable[[], object]
) -> list[Prediction]:
    """Predict each whole recording with the fit to its first part."""
    first = [cut(one, (1.0 - HELD_OUT) * float(np.ptp(one.motion.times))) for one in recordings if one.motion]
    start = dict(zip(fit.estimate.names, fit.estimate.values.tolist(), strict=True))
    model = velocity_drive.base_model(first, start, fit.fixed, robot, configured)
    trained = estimate(model, [one.motion.moved[one.motion.usable] for one in first if one.motion], 1, tell)
    values = dict(zip(trained.names, trained.values.tolist(), strict=True)) | fit.fixed
    delays = [values.pop(name, 0.0) for name in velocity_drive.DELAYS]
    predictions = []
    for recording, part in zip(recordings, first, strict=True):
        motion = recording.motion
        assert motion  # noqa: S101 (for mypy: checked by the caller)
        assert part.motion  # noqa: S101 (for mypy, too)
        run = velocity_drive.simulated(recording, values, robot, configured)
        predictions.append(prediction_of(
            recording.name, motion.times, motion.moved, np.diff(run.at(motion.times, delays), axis=0), motion.usable,
            float(part.motion.times[-1])))
    return predictions
