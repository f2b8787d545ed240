"""The calibration of odometry by a pose from outside: the errors of its radii and of its wheel separation."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.identification.estimation import Estimate, Model, estimate
from mobile_robot_control.identification.recorded import Motion, Recorded, moved_between
from mobile_robot_control.model.robot import Robot

ERRORS = ('plant.odometry.radius_error[0]', 'plant.odometry.radius_error[1]', 'plant.odometry.separation_error')
_OFFSET = 'offset'
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
        found = []
        for one, true in zip(recordings, seen, strict=True):
            assert one.motion  # noqa: S101 (for mypy: checked by the caller)
            way = np.concatenate([np.zeros((1, 2)), np.cumsum(one.motion.moved, axis=0)])
            at = np.column_stack([np.interp(true.times - values[3], one.motion.times, way[:, n]) for n in (0, 1)])
            found.append(corrected(np.diff(at, axis=0), values[:3], robot))
        return found

    model = Model((*ERRORS, _OFFSET), np.zeros(4), np.array([-0.5, -0.5, -0.5, -1.0]),
                  np.array([0.5, 0.5, 0.5, 1.0]), np.array([1e-5, 1e-5, 1e-5, 1e-3]), outputs)
    return estimate(model, [true.moved for true in seen])


def _thinned(one: Recorded) -> Motion:
    """Return the motion of the pose from outside, over intervals within odometry."""
    assert one.truth  # noqa: S101 (for mypy: checked by the caller)
    assert one.motion  # noqa: S101 (for mypy, too)
    times, way = one.truth.times, np.concatenate(
        [np.zeros((1, 2)), np.cumsum(moved_between(one.truth.values), axis=0)])
    inside = np.flatnonzero((times > one.motion.times[0] + 1.0) & (times < one.motion.times[-1] - 1.0))
    chosen = inside[np.unique(np.searchsorted(times[inside], np.arange(times[inside[0]], times[inside[-1]], _APART)))]
    return Motion(times[chosen], np.diff(way[chosen], axis=0), np.ones(chosen.size - 1, bool))


def corrected(moved: Floats, errors: Floats, robot: Robot) -> Floats:
    """Convert distances and turns of odometry to true ones, for the errors of its radii and its separation."""
    apart = robot.wheel_separation
    half = 0.5 * apart * (1.0 + errors[2])
    right = (moved[:, 0] + half * moved[:, 1]) / (1.0 + errors[0])
    left = (moved[:, 0] - half * moved[:, 1]) / (1.0 + errors[1])
    return np.column_stack([0.5 * (right + left), (right - left) / apart])


def with_true_motion(one: Recorded, errors: Floats, robot: Robot) -> Recorded:
    """Return a recording with the motion of odometry, corrected for its errors."""
    assert one.motion  # noqa: S101 (for mypy: checked by the caller)
    return one._replace(motion=Motion(one.motion.times, corrected(one.motion.moved, errors, robot),
                                      one.motion.usable))


def alignment(one: Recorded) -> Alignment:
    """Return the planar motion from odometry's frame to that of the pose from outside, from positions on both paths."""
    assert one.truth  # noqa: S101 (for mypy: checked by the caller)
    assert one.odometry  # noqa: S101 (for mypy, too)
    inside = (one.odometry.times >= one.truth.times[0]) & (one.odometry.times <= one.truth.times[-1])
    seen = one.odometry.values[inside, :2]
    true = np.column_stack([np.interp(one.odometry.times[inside], one.truth.times, one.truth.values[:, n])
                            for n in (0, 1)])
    # the argument of the sum of all products of complex numbers is the least-squares rotation
    there, here = (part[:, 0] + 1j * part[:, 1] for part in (true, seen))
    rotation = float(np.angle(((there - there.mean()) * (here - here.mean()).conj()).sum()))
    origin = there.mean() - np.exp(1j * rotation) * here.mean()
    return Alignment(float(origin.real), float(origin.imag), rotation)
