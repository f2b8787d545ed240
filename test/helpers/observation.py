"""What a law sees in tests that care for error and reference alone, what it answers, and the motion that follows."""

import math

from scipy.integrate import solve_ivp

from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.tracking_error import tracking_error
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


def driven(law, gains, cart_at, start, times):
    """Return the poses of a robot that moves exactly as a static law's module asks, behind a cart by time."""
    def motion(t, state):
        cart, pose = cart_at(t), Pose(*state)
        _, (v, omega) = law.step(NoState(), observed(tracking_error(cart.pose, pose), cart), gains, 0.0)
        return [v * math.cos(pose.heading), v * math.sin(pose.heading), omega]

    states = solve_ivp(motion, (0.0, times[-1]), start, 'DOP853', times, rtol=1e-10, atol=1e-12).y.T
    return [Pose(*state) for state in states]


def inputs(command, measured=(0.0, 0.0), acceleration=NO_ACCELERATION, applied=UNKNOWN_TORQUE):
    """Return the inputs of a velocity law."""
    return VelocityInputs(BodyVelocity(*command), acceleration, BodyVelocity(*measured), applied)
