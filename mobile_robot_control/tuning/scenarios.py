"""What a controller is tried in: curves, starts, robots that differ from the nominal one."""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.configuration import Configuration
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.imperfections import Delay, Noise, empty_line
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.curves import CURVES, reference_at
from mobile_robot_control.simulation.trial import Trial, prepare


class Scenario(NamedTuple):
    """
    One situation.

    Attributes
    ----------
    curve : str
        Of CURVES.
    scale : float
        Of the curve [m].
    start : Pose or None
        Where the robot starts, relative to the reference cart's start, in the odometry frame's axes; None for the
        configured `initial_pose`.
    mass, friction : float
        Factors on the configured robot's mass and inertia, and on its friction.
    noise : Noise
        On what is measured.
    delay : int
        Of the torques, in periods of the velocity loop.

    """

    curve: str
    scale: float
    start: Pose | None = None
    mass: float = 1.0
    friction: float = 1.0
    noise: Noise = Noise()
    delay: int = 0


class Spread(NamedTuple):
    """
    From what random scenarios are drawn.

    Attributes
    ----------
    curves : tuple of str
        Each as likely as the others.
    scales : tuple of float
        Likewise [m].
    within : float
        Largest distance of the start from the cart's [m]; the heading is any.
    variation : float
        Largest relative change of mass (with the inertia) and of friction.
    noise : Noise
        Of all; the seeds are drawn.
    longest_delay : int
        Delays are drawn from 0 up to it.

    """

    curves: tuple[str, ...]
    scales: tuple[float, ...]
    within: float = 1.0
    variation: float = 0.2
    noise: Noise = Noise()
    longest_delay: int = 0


def configured(configuration: Configuration) -> Scenario:
    """
    Give the situation of a configuration.

    Parameters
    ----------
    configuration : Configuration
        Checked.

    Returns
    -------
    Scenario
        With its noise and its delay.

    """
    curve, imperfect = configuration.reference_cart.curve, configuration.plant.imperfections
    return Scenario(curve.curve, curve.placement.scale, noise=imperfect.noise, delay=imperfect.delay.velocity_steps)


def draw(spread: Spread, count: int, seed: int) -> list[Scenario]:
    """
    Draw random scenarios.

    Parameters
    ----------
    spread : Spread
        From what.
    count : int
        How many.
    seed : int
        The same seed, the same scenarios; a longer list begins with the shorter one.

    Returns
    -------
    list of Scenario
        Starts are spread evenly over the disc.

    """
    rng = np.random.default_rng(seed)
    drawn = []
    for _ in range(count):
        curve, scale, radius, angle, heading, mass, friction, noise, delay = rng.random(9).tolist()
        distance, direction = spread.within * math.sqrt(radius), 2.0 * math.pi * angle
        drawn.append(Scenario(
            spread.curves[int(curve * len(spread.curves))],
            spread.scales[int(scale * len(spread.scales))],
            Pose(distance * math.cos(direction), distance * math.sin(direction), math.pi * (1.0 - 2.0 * heading)),
            1.0 + spread.variation * (2.0 * mass - 1.0),
            1.0 + spread.variation * (2.0 * friction - 1.0),
            spread.noise._replace(seed=int(noise * 2**32)),
            int(delay * (spread.longest_delay + 1)),
        ))
    return drawn


def trial(configuration: Configuration, scenario: Scenario, laps: float, late: float) -> Trial:
    """
    Make the trial of a configuration in a scenario.

    Parameters
    ----------
    configuration : Configuration
        Checked; the controllers keep its nominal robot.
    scenario : Scenario
        The situation.
    laps : float
        Length of the run.
    late : float
        Laps after which the late totals count.

    Returns
    -------
    Trial
        The robot starts at rest.

    """
    cart = configuration.reference_cart
    placement = cart.curve.placement._replace(scale=scenario.scale)
    prepared = prepare(configuration, laps * placement.period, late * placement.period)
    plant = prepared.loop.plant
    robot = plant.robot._replace(
        mass=plant.robot.mass * scenario.mass,
        inertia=plant.robot.inertia * scenario.mass,
        viscous_friction=plant.robot.viscous_friction * scenario.friction,
    )
    delay = Delay(scenario.delay)
    state = prepared.state
    if scenario.start is not None:
        cart_start = reference_at(CURVES[scenario.curve], 0.0, placement).pose
        offset = scenario.start
        at = Pose(cart_start.x + offset.x, cart_start.y + offset.y, cart_start.heading + offset.heading)
        state = state._replace(plant=dynamics.at_rest(at))
    return prepared._replace(
        curve=scenario.curve,
        loop=prepared.loop._replace(
            plant=dynamics.sample(robot, plant.dt, plant.centripetal_coupling),
            imperfections=prepared.loop.imperfections._replace(noise=scenario.noise, delay=delay),
            placement=placement,
        ),
        state=state._replace(line=empty_line(delay)),
    )


def grid(
    nominal: Scenario,
    curves: Sequence[str],
    scales: Sequence[float],
    starts: Sequence[Pose | None],
    masses: Sequence[float],
    frictions: Sequence[float],
    delays: Sequence[int],
) -> list[Scenario]:
    """
    List every combination.

    Parameters
    ----------
    nominal : Scenario
        Its noise is kept.
    curves, scales, starts, masses, frictions, delays : sequences
        As the fields of Scenario.

    Returns
    -------
    list of Scenario
        The last argument changes fastest.

    """
    return [Scenario(curve, scale, start, mass, friction, nominal.noise, delay)
            for curve, scale, start, mass, friction, delay
            in itertools.product(curves, scales, starts, masses, frictions, delays)]
