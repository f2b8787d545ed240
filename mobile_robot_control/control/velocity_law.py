"""The record of a velocity law: its step from body velocity to wheel torques, its gains, and how it joins a run."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from mobile_robot_control.control.law import LawFailedError, NoState
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, WheelTorque


class VelocityInputs(NamedTuple):
    """
    The inputs of a velocity law.

    Attributes
    ----------
    command : BodyVelocity
        Command, brought forward to now along the acceleration [m/s], [rad/s].
    acceleration : BodyAcceleration
        Of the reference [m/s²], [rad/s²]; 0 without feedforward.
    measured : BodyVelocity
        From the wheels [m/s], [rad/s].
    applied : WheelTorque
        Applied over the last period [N m]; nan if unknown, and for a law that does not read it.

    """

    command: BodyVelocity
    acceleration: BodyAcceleration
    measured: BodyVelocity
    applied: WheelTorque


class VelocityLawStep(Protocol):
    """
    One step of a velocity law: a pure function of floats and NamedTuples.

    With the functions of `mobile_robot_control.elementary` it compiles, and has the same bits on every machine.
    """

    def __hash__(self) -> int:
        """Steps are functions, or compared as they are."""

    def __call__(
        self, state: Any, inputs: VelocityInputs, gains: Any, robot: Robot, limit: float, dt: float, /
    ) -> tuple[Any, WheelTorque]:
        """
        Compute the wheel torques from the present measurement.

        Parameters
        ----------
        state : NamedTuple
            Of the previous step; `VelocityLaw.start` at a run's start.
        inputs : VelocityInputs
            Command, acceleration, measured velocity and applied torque.
        gains : NamedTuple
            The law's parameters.
        robot : Robot
            Nominal constants, never those of a drawn robot.
        limit : float
            Of each wheel's torque [N m]; 0 means none. Beyond it a law must not wind up.
        dt : float
            Sampling period [s].

        Returns
        -------
        tuple of NamedTuple and WheelTorque
            The state for the next step and the torques [N m].

        """


class IntegralAction(NamedTuple):
    """
    The integral of a channel near its command.

    Attributes
    ----------
    name : str
        Its time as a formula of the gains.
    time : float
        Over which a lasting error is removed [s]; infinite without an integral.
    constant : float
        Time constant of the closed loop without it [s].

    """

    name: str
    time: float
    constant: float


class VelocityLaw(NamedTuple):
    """
    A velocity law. A file or module of a law has one, named VELOCITY_LAW, or passes it to `register`.

    Attributes
    ----------
    name : str
        Value of `velocity_controller.controller_type`, and name of the law's group of parameters; the group of the PI
        law is `gains`.
    step : VelocityLawStep
        Computes the torques.
    gains : type
        NamedTuple that declares the law's group: each field annotated with Field, each with a default.
    start : NamedTuple
        The state at a run's start.
    joining : callable or None
        ``joining(measured, torque, gains, robot) -> state``, the state of a law that takes over from another one at
        its last torque [N m]; None for `start`.
    fed : VelocityLawStep or None
        The step with feedforward of the torques; None for `step`, which then reads the acceleration.
    reads_applied : bool
        Whether the step reads the torque that was applied.
    estimates : tuple of str
        Fields of the state that adapt while the robot drives; margins hold them.
    integrals : callable or None
        ``integrals(gains, robot)``, the IntegralAction of each channel; a search warns of slow ones.

    """

    name: str
    step: VelocityLawStep
    gains: type
    start: Any = NoState()
    joining: Callable[[BodyVelocity, WheelTorque, Any, Robot], Any] | None = None
    fed: VelocityLawStep | None = None
    reads_applied: bool = False
    estimates: tuple[str, ...] = ()
    integrals: Callable[[Any, Robot], tuple[IntegralAction, ...]] | None = None

    @property
    def group(self) -> str:
        """Name of its group of parameters."""
        return 'gains' if self.name == PI else self.name


_SLOW = 10.0
"""Integral time in time constants of the proportional loop, above which a lasting error outlives a manoeuvre."""

PI = 'pi'
"""The law of the chapter, whose parameters keep their group `gains`."""


class VelocityLawFailedError(LawFailedError):
    """A velocity law raised, or returned torques that are not finite."""


def slow_integrals(law: VelocityLaw, gains: Any, robot: Robot) -> str:
    """
    Describe integral times of more than ten times the time constant of their closed proportional loop; '' for none.

    That loop is taken without the friction that an integral is for.
    """
    found = law.integrals(gains, robot) if law.integrals else ()
    return ' and '.join(f'{name} = {time:.3g} s, {time / constant:.0f} time constants of its proportional loop'
                        for name, time, constant in found if time > _SLOW * constant)


@jitable
def is_finite(torque: WheelTorque) -> bool:
    """Return whether torques are finite; others are a failure of the law."""
    return math.isfinite(torque.right) and math.isfinite(torque.left)


@jitable
def held_by_limit(unlimited: float, limited: float, error: float) -> bool:
    """Return whether integration of an error would push a channel further beyond its limit."""
    return (unlimited - limited) * error > 0.0
