"""Position laws: what one takes and returns, and the list of those that `controller_type` may name."""

from typing import Annotated, Any, NamedTuple, Protocol

from mobile_robot_control.control import backstepping, fuzzy, hybrid_backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains, NoState
from mobile_robot_control.control.command_limits import Limits
from mobile_robot_control.control.fuzzy import FuzzyGains
from mobile_robot_control.control.hybrid_backstepping import HybridGains, HybridState, SeekingGains
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Reference, TrackingError


class LawStep(Protocol):
    """
    One step of a position law: a pure function of floats and NamedTuples that uses ``math`` only, so that it compiles.

    State and gains are NamedTuples of the law's own.
    """

    def __call__(
        self, state: Any, error: TrackingError, reference: Reference, gains: Any, dt: float, /
    ) -> tuple[Any, BodyVelocity]:
        """
        Compute the command from the present error and reference.

        Parameters
        ----------
        state : NamedTuple
            Of the step before; `Law.start` at a run's start.
        error : TrackingError
            e1, e2 [m], e3 [rad] in the robot's frame.
        reference : Reference
            Pose, v_r [m/s] and ω_r [rad/s].
        gains : NamedTuple
            The law's parameters.
        dt : float
            Period to the next step [s].

        Returns
        -------
        tuple of NamedTuple and BodyVelocity
            The state for the next step and the command [m/s], [rad/s].

        """


class Law(NamedTuple):
    """
    A position law.

    Attributes
    ----------
    step : LawStep
        Computes the command.
    start : NamedTuple
        The state at a run's start.
    joining : NamedTuple
        The state of a law that joins a run under way.
    """

    step: LawStep
    start: Any
    joining: Any


LAWS = {
    'backstepping': Law(backstepping.step, NoState(), NoState()),
    'hybrid_backstepping': Law(hybrid_backstepping.step, HybridState(), hybrid_backstepping.TRACKING),
    'fuzzy': Law(fuzzy.step, NoState(), NoState()),
}


class PositionControl(NamedTuple):
    """Which position law runs, the gains of all laws, and the limits of the command."""

    controller_type: Annotated[
        str, Field('', 'which position law runs', choices=tuple(LAWS), live=True)
    ] = 'backstepping'
    backstepping: BacksteppingGains = BacksteppingGains()
    hybrid_backstepping: SeekingGains = SeekingGains()
    fuzzy: FuzzyGains = FuzzyGains()
    limits: Limits = Limits()


def select(parameters: PositionControl) -> tuple[Law, Any]:
    """Return the law that checked parameters name, and its gains."""
    gains = {
        'backstepping': parameters.backstepping,
        'hybrid_backstepping': HybridGains(parameters.backstepping, parameters.hybrid_backstepping),
        'fuzzy': parameters.fuzzy,
    }
    return LAWS[parameters.controller_type], gains[parameters.controller_type]
