"""The registry of position laws: what `controller_type` may name."""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.control import backstepping, fuzzy, hybrid_backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains, NoState
from mobile_robot_control.control.fuzzy import FuzzyGains
from mobile_robot_control.control.hybrid_backstepping import HybridGains, HybridState, SeekingGains
from mobile_robot_control.control.limits import Limits
from mobile_robot_control.fields import Field


class Law(NamedTuple):
    """
    A position law.

    Attributes
    ----------
    step : callable
        ``step(state, error, reference, gains, dt) -> (state, BodyVelocity)``, a pure function.
    start : NamedTuple
        The state at a run's start.
    joining : NamedTuple
        The state of a law that joins a run under way.

    """

    step: Callable[..., tuple[Any, Any]]
    start: Any
    joining: Any


LAWS = {
    'backstepping': Law(backstepping.step, NoState(), NoState()),
    'hybrid_backstepping': Law(hybrid_backstepping.step, HybridState(), hybrid_backstepping.TRACKING),
    'fuzzy': Law(fuzzy.step, NoState(), NoState()),
}


class PositionControl(NamedTuple):
    """Which position law runs, the gains of all of them, and what any of them may ask for."""

    controller_type: Annotated[
        str, Field('', 'which position law runs', choices=tuple(LAWS), live=True)
    ] = 'backstepping'
    backstepping: BacksteppingGains = BacksteppingGains()
    hybrid_backstepping: SeekingGains = SeekingGains()
    fuzzy: FuzzyGains = FuzzyGains()
    limits: Limits = Limits()


def select(parameters: PositionControl) -> tuple[Law, Any]:
    """
    Give the law that is asked for, with its gains.

    Parameters
    ----------
    parameters : PositionControl
        Checked parameters.

    Returns
    -------
    tuple of Law and NamedTuple
        The law and what its step takes as gains.

    """
    gains = {
        'backstepping': parameters.backstepping,
        'hybrid_backstepping': HybridGains(parameters.backstepping, parameters.hybrid_backstepping),
        'fuzzy': parameters.fuzzy,
    }
    return LAWS[parameters.controller_type], gains[parameters.controller_type]
