"""What a law sees in tests that care for error and reference alone, and what it answers."""

from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.velocity_law import VelocityInputs
from mobile_robot_control.quantities import (
    NO_ACCELERATION,
    UNKNOWN_TORQUE,
    BodyVelocity,
    Observation,
    Pose,
    Reference,
    TrackingError,
)


def observed(error, reference):
    """Return the observation of a robot that stands."""
    return Observation(error, reference, BodyVelocity(0.0, 0.0))


def ask(law, error, velocity, gains, dt=0.01, state=NoState()):  # noqa: B008 (immutable)
    """Return the next state and the command of a law's module behind a cart of this velocity."""
    reference = Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity))
    return law.step(state, observed(TrackingError(*error), reference), gains, dt)


def inputs(command, measured=(0.0, 0.0), acceleration=NO_ACCELERATION, applied=UNKNOWN_TORQUE):
    """Return the inputs of a velocity law."""
    return VelocityInputs(BodyVelocity(*command), acceleration, BodyVelocity(*measured), applied)
