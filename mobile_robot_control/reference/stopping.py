"""The shortest stop on the present motion of the reference cart."""

import math
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Reference
from mobile_robot_control.reference.motion import Part, PathMotion, Rest, Turn, turn
from mobile_robot_control.reference.path_parameters import PathRequest, Timing
from mobile_robot_control.reference.path_shape import Span, lay_grid
from mobile_robot_control.reference.planned_path import ImpossibleError, PlannedPath, plan_grid

STANDS = 1e-3
"""[m/s], [rad/s]: a slower cart counts as standing."""
SLACK = (1.0, 1.01)
"""Shares of the limits; the previous motion may exceed them by this much between two points of its grid."""
_HALVINGS = 20


def moves(before: Reference) -> bool:
    """Return whether a cart is faster than STANDS."""
    return max(map(abs, before.velocity)) > STANDS


def slackened(request: PathRequest, share: float) -> PathRequest:
    """Return a request with a share of its limits."""
    factor, fraction, *limits = request.timing
    return request._replace(
        timing=Timing(factor, fraction, *(share * limit for limit in limits)),
        drive=request.drive._replace(stall_torque=share * request.drive.stall_torque))


def stop(rest: Rest, request: PathRequest, before: Reference) -> PathMotion:
    """
    Plan the shortest stop along the present motion.

    Parameters
    ----------
    rest : Rest
        The present motion, from the cart on.
    request : PathRequest
        With the limits.
    before : Reference
        Motion of the cart, faster than STANDS.

    """
    present = rest.parts[0]
    # rather by more than a limit than not at all
    for slack in (*SLACK, 1.02, 1.05, 1.1, 1.2, 1.5, 2.0):
        limits = slackened(request, slack)
        if isinstance(present, Turn):
            stopped: Part | None = _stopped_turn(present, rest.time, limits, before)
        else:
            assert isinstance(present, PlannedPath)  # noqa: S101 (for mypy: the cart moves)
            stopped = _stop(present.remaining(rest.time), limits, abs(before.velocity.linear), present.backward)
        if stopped is not None:
            return PathMotion([stopped])
    raise ParameterError(['no stop on the rest of the path keeps the limits of timing'])


def _stopped_turn(present: Turn, time: float, request: PathRequest, before: Reference) -> Turn | None:
    """Plan the shortest stop of a turn on the spot from its angular velocity; None if the limits do not allow one."""
    speed, stop = abs(before.velocity.angular), None
    least, most = 0.0, present.left(time)
    for _ in range(_HALVINGS):
        angle = most if stop is None else 0.5 * (least + most)
        with suppress(ParameterError):
            stop, most = turn(before.pose, math.copysign(angle, present.angle), request, speed), angle
            continue
        if stop is None:
            return None
        least = angle
    return stop


def _stop(rest: Sequence[Span], request: PathRequest, speed: float, backward: bool) -> PlannedPath | None:
    """Plan the shortest stop from a speed [m/s]; None if the limits do not allow one."""
    def first_part(count: int) -> PlannedPath | None:
        """Return the motion to a stop within so many intervals of the grid; None if there is none."""
        part = grid.first(count)
        with suppress(ImpossibleError):
            return plan_grid(rest, part, request.timing, request.drive, np.full(count, np.inf), speed, backward)
        return None

    count = 1
    while True:
        grid = lay_grid(list(rest[:count]))
        longest = len(grid.length)
        stopped = first_part(longest)
        if stopped is not None:
            break
        if count >= len(rest):
            return None
        count *= 2
    shortest = 0
    while longest - shortest > 1:
        middle = (shortest + longest) // 2
        shorter = first_part(middle)
        if shorter is None:
            shortest = middle
        else:
            stopped, longest = shorter, middle
    if longest > 1:
        return stopped
    # within the first interval, on a grid of its own: a slow cart would take long to its end
    return _stop([rest[0].until(float(grid.u[0, 1]))], request, speed, backward) or stopped
