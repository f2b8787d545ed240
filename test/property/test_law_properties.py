"""Properties of the position laws that have no gains of one side: symmetry, and the feed-forward on the cart."""

import pytest
from each import each_row
from hypothesis import given, settings
from hypothesis import strategies as st
from observation import observed

from mobile_robot_control.control.laws import BUILT_IN, PositionControl, select
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError

# the chapter's laws are in test_control_properties: with gains of one side, or without feed-forward
SYMMETRIC = [law.name for law in BUILT_IN if law.name not in ('backstepping', 'hybrid_backstepping', 'fuzzy')]
SELECTED = {name: select(PositionControl(controller_type=name), 0.01) for name in SYMMETRIC}
SMALL = st.floats(-5.0, 5.0)
ERRORS = st.builds(TrackingError, SMALL, SMALL, st.floats(-3.14, 3.14))
VELOCITIES = st.builds(BodyVelocity, SMALL, SMALL)


def steps(name, inputs):
    """Return the commands for some pairs of error and velocity of the cart."""
    law, gains = SELECTED[name]
    state, commands = law.start, []
    for error, velocity in inputs:
        state, command = law.step(state, observed(error, Reference(Pose(0.0, 0.0, 0.0), velocity)), gains, 0.01)
        commands.append(command)
    return commands


@each_row('name', SYMMETRIC)
@settings(max_examples=50)
@given(inputs=st.lists(st.tuples(ERRORS, VELOCITIES), min_size=1, max_size=4))
def test_the_command_for_the_mirrored_error_is_mirrored(name, inputs):
    mirrored = [(TrackingError(e1, -e2, -e3), BodyVelocity(v, -omega)) for (e1, e2, e3), (v, omega) in inputs]
    for one, other in zip(steps(name, inputs), steps(name, mirrored), strict=True):
        assert (other.linear, -other.angular) == one


@each_row('name', SYMMETRIC)
@settings(max_examples=50)
@given(velocity=VELOCITIES.filter(lambda velocity: abs(velocity.linear) > 0.2))
def test_on_the_cart_the_command_is_its_velocity(name, velocity):
    cart = (TrackingError(0.0, 0.0, 0.0), velocity)
    for command in steps(name, [cart] * 3):
        assert command == pytest.approx(velocity, rel=1e-13, abs=1e-13)
