"""Margins of the velocity loop and of the position loop along a lap of the curve."""

import math
from collections.abc import Sequence
from itertools import islice
from typing import NamedTuple

from mobile_robot_control.analysis.lap import FollowedTick, NotFollowedError, followed_lap, lap_loop
from mobile_robot_control.analysis.lap_multiplier import lap_multiplier
from mobile_robot_control.analysis.linearisation import linear_position_loop, linear_velocity_loop
from mobile_robot_control.analysis.margins import UNKNOWN, Margins, longest_delay, margins_of
from mobile_robot_control.analysis.modelled import drive_of, pattern_of, smooth_part
from mobile_robot_control.configuration.nodes import Configuration, course_of

_POINTS = 24
"""Points of the lap at which the position loop is analysed; fewer if a pattern of several periods costs more."""
_LEAST_POINTS = 12
CERTAIN = 1.25
"""Gain margin, 2 dB: with it at every point of a lap, the whole lap is stable without further analysis."""
_VELOCITY_EVERY = 6
"""The velocity loop hardly changes along the curve: every sixth point is enough."""


class LapMargins(NamedTuple):
    """
    The worst margins along the curve.

    Attributes
    ----------
    margins : Margins
        The smallest ones, and the largest `lowest_gain`.
    gain_time, delay_time : float
        Time of the smallest gain and delay margin, after the beginning of the lap [s].

    """

    margins: Margins
    gain_time: float
    delay_time: float


class LoopMargins(NamedTuple):
    """
    The margins of both loops of a configuration.

    Attributes
    ----------
    velocity : LapMargins or None
        Delays in velocity periods; None for a base with its own velocity loop.
    position : LapMargins
        Delays in position periods.
    reason : str
        Why margins are unknown; '' if they are known.
    multiplier : float
        Factor by which an error of the position loop changes over a lap; nan if it is unknown, or certainly below 1,
        because every point of the lap has a gain margin of at least `CERTAIN`.

    """

    velocity: LapMargins | None
    position: LapMargins
    reason: str = ''
    multiplier: float = math.nan


def _worst(found: Sequence[tuple[float, Margins]]) -> LapMargins:
    """Return the worst of margins by time; unknown if one of them is."""
    if any(math.isnan(margins.gain) for _, margins in found):
        return LapMargins(UNKNOWN, math.nan, math.nan)
    gain_time, gain = min(((time, margins.gain) for time, margins in found), key=lambda pair: pair[1])
    delay_time, delay = min(((time, margins.delay) for time, margins in found), key=lambda pair: pair[1])
    lowest = max(margins.lowest_gain for _, margins in found)
    return LapMargins(Margins(gain, lowest, delay), gain_time, delay_time)


def loop_margins(configuration: Configuration) -> LoopMargins:
    """
    Compute the margins of both loops along a lap.

    Parameters
    ----------
    configuration : Configuration
        Checked. Noise, limits, quantisation, dead zones and stiction are left out (`smooth_part`).

    Returns
    -------
    LoopMargins
        With a reason if the loop does not follow the reference, or has no linearisation.

    Notes
    -----
    The loop varies along the curve. Each point is analysed as if the robot continued its motion there for ever, in
    coordinates that move with the reference. This covers changes that are slow compared with the settling of the loop.
    A stretch of instability too short to matter counts fully in the margins; the multiplier of the lap decides whether
    the loop is stable.

    """
    smooth, by_torque = smooth_part(configuration), drive_of(configuration) == 'torque'
    lap, period, pattern = lap_loop(smooth), course_of(smooth.reference_cart).period, pattern_of(smooth)
    nothing = LapMargins(UNKNOWN, math.nan, math.nan)
    if not pattern:
        return LoopMargins(nothing if by_torque else None, nothing, 'the rates of the base have no common pattern')
    ticks = math.ceil(period / lap.loop.position_dt)
    points = max(_LEAST_POINTS, _POINTS // pattern)
    chosen = sorted({n * ticks // points for n in range(points)})
    velocity: list[tuple[float, Margins]] = []
    position: list[tuple[float, Margins]] = []
    followed: list[FollowedTick] = []
    try:
        followed += islice(followed_lap(smooth), -(-ticks // pattern) * pattern + pattern)
        for first in chosen:
            window = followed[first:first + pattern]
            time = window[0].time % period
            if by_torque and len(position) % _VELOCITY_EVERY == 0:
                velocity.append((time, margins_of(linear_velocity_loop(lap, window[0]))))
            position.append((time, margins_of(linear_position_loop(lap, window), longest_delay(lap.loop.position_dt))))
    except NotFollowedError as error:
        return LoopMargins(nothing if by_torque else None, nothing, str(error))
    found = LoopMargins(_worst(velocity) if by_torque else None, _worst(position))
    if found.position.margins.gain < CERTAIN:
        found = found._replace(multiplier=lap_multiplier(lap, followed[:-(-ticks // pattern) * pattern], pattern))
    known = all(not math.isnan(loop.margins.gain) for loop in found[:2] if loop is not None)
    return found if known else found._replace(reason='the loop has no derivative at a point of the lap')
