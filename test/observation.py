"""What a law sees in tests that care for error and reference alone."""

from mobile_robot_control.quantities import BodyVelocity, Observation


def observed(error, reference):
    """Return the observation of a robot that stands."""
    return Observation(error, reference, BodyVelocity(0.0, 0.0))
