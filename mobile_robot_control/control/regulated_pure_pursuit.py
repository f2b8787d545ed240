"""Regulated pure pursuit, after Macenski, Singh, Martin and Gines, along the reference's horizon."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.control.ramsete import sinc
from mobile_robot_control.elementary import sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation, Reference

_HORIZON = 20
_STANDING = 1e-6
"""[m/s]: at a smaller speed the path leads straight on, as v_r and ω_r say nothing of its curvature."""
_LEAST = 1e-12
"""[m²]: least square of a distance that divides."""


class PursuitGains(NamedTuple):
    """The lookahead distance, the regulation of the speed, and the gain of the gap ahead."""

    lookahead_time: Annotated[
        float, Field('s', 'lookahead distance by speed: larger turns less for an error aside, and cuts corners',
                     above=0.0, live=True, search=(0.05, 2.0))
    ] = 0.776371
    least_lookahead: Annotated[
        float, Field('m', 'least lookahead distance: larger turns less while the robot is slow', above=0.0, live=True)
    ] = 0.1
    radius: Annotated[
        float, Field('m', 'radius of the pursued arc below which the robot slows in proportion, and beyond which it '
                     'keeps its speed: larger slows sooner in a bend', above=0.0, live=True)
    ] = 0.1
    kx: Annotated[
        float, Field('1/s', 'speed for each metre that the cart is ahead: larger closes this gap sooner, 0 does not; '
                     'the source has none', minimum=0.0, live=True, search=(0.0, 20.0))
    ] = 1.23213


@jitable
def _beyond(x: float, y: float, last: Reference, frame: float, lookahead: float) -> tuple[float, float]:
    """Return the lookahead point beyond the last reference, at x, y: its path goes on with its curvature."""
    v, omega = last.velocity
    way = math.copysign(1.0, v)
    sin, cos = sin_cos(last.pose.heading + frame)
    t_x, t_y = way * cos, way * sin
    # along the tangent, from its point at the lookahead distance, or nearest to the robot
    aside = x * t_y - y * t_x
    length = max(0.0, math.sqrt(max(0.0, lookahead * lookahead - aside * aside)) - (x * t_x + y * t_y))
    half = 0.0
    if abs(v) > _STANDING:
        # on a circle within the distance the opposite point is the farthest one
        if length * abs(omega) > math.pi * abs(v):
            length = math.pi * abs(v / omega)
        half = 0.5 * length * omega / abs(v)
    # a chord of the arc leads at half its turn
    chord = length * sinc(half)
    sin, cos = sin_cos(half)
    return x + chord * (t_x * cos - t_y * sin), y + chord * (t_y * cos + t_x * sin)


@jitable
def lookahead_point(observation: Observation, lookahead: float) -> tuple[float, float]:
    """
    Return the first point of the cart's coming path at a distance, from which the path leads away.

    Parameters
    ----------
    observation : Observation
        e1, e2 [m], e3 [rad], the reference and its horizon.
    lookahead : float
        Distance from the robot [m].

    Returns
    -------
    tuple of float
        Ahead of the robot and to its left [m]. Where the cart is farther away it is the cart; beyond the horizon the
        path goes on with its curvature there.

    """
    e1, e2, e3 = observation.error
    last = observation.reference
    x_r, y_r, heading = last.pose
    # from the plane to the robot's frame
    frame = e3 - heading
    sin, cos = sin_cos(frame)
    x, y, away = e1, e2, math.sqrt(e1 * e1 + e2 * e2)
    for coming in observation.horizon:
        along, across = coming.pose.x - x_r, coming.pose.y - y_r
        next_x, next_y = e1 + cos * along - sin * across, e2 + cos * across + sin * along
        next_away = math.sqrt(next_x * next_x + next_y * next_y)
        if next_away >= lookahead and next_away >= away:
            share = max(0.0, lookahead - away) / max(next_away - away, _LEAST)
            return x + share * (next_x - x), y + share * (next_y - y)
        x, y, away, last = next_x, next_y, next_away, coming
    return _beyond(x, y, last, frame, lookahead)


@jitable
def step(state: NoState, observation: Observation, gains: PursuitGains, dt: float) -> tuple[NoState, BodyVelocity]:
    """
    Compute the body velocity on the arc to a lookahead point of the path, slower where the arc bends.

    The adaptive pure pursuit and the curvature heuristic of [1]_: the lookahead distance grows with the speed, and the
    speed falls in proportion to the arc's radius where that is small.

    Parameters
    ----------
    state : NoState
        Returned unchanged.
    observation : Observation
        e1, e2 [m], e3 [rad], the reference and its horizon are used.
    gains : PursuitGains
        Lookahead time, its least distance, radius, k_x.
    dt : float
        Not used: the law is static.

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    Notes
    -----
    The path begins at the cart, which moves by its time, and not at the robot's nearest point. The speed is the cart's,
    plus k_x times the gap ahead; [1]_ has a constant one. Left out are the upper limit of the lookahead distance, the
    slowing near obstacles and before the goal, the check for collisions and the turn towards the path: there is no
    costmap, and the cart stops by itself. A point straight behind the robot makes no arc, so a robot that faces away
    may drive on. Nothing holds the heading.

    References
    ----------
    .. [1] S. Macenski, S. Singh, F. Martin and J. Gines, "Regulated pure pursuit for robot path tracking", Autonomous
       Robots 47, 2023, pp. 685-694.

    """
    e1, e2, e3 = observation.error
    v_r = observation.reference.velocity.linear
    way, speed = math.copysign(1.0, v_r), abs(v_r)
    # L = v l_t
    x, y = lookahead_point(observation, max(gains.least_lookahead, gains.lookahead_time * speed))
    sin, cos = sin_cos(e3)
    speed = max(0.0, speed + gains.kx * way * (e1 * cos + e2 * sin))
    squared = x * x + y * y
    if way * x < 0.0 and y != 0.0:
        # the arc to a point behind would first lead away, and the farther behind, the less it would bend
        y = math.copysign(math.sqrt(squared), y)
    # κ = 2 y / L², and v' = v / (r |κ|) where |κ| > 1 / r, written without a division by y
    divisor = max(squared, 2.0 * gains.radius * abs(y), _LEAST)
    return state, BodyVelocity(way * speed * squared / divisor, way * speed * 2.0 * y / divisor)


LAW = Law('regulated_pure_pursuit', step, PursuitGains, horizon=_HORIZON)
