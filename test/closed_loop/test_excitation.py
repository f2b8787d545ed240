"""An excitation stays in its box, and comes to all of its manoeuvres."""

import pytest
from drawn import drawn
from promising import BASES
from stand_in_model import drive

from mobile_robot_control.identification.excitation import Area, Excited, excite
from mobile_robot_control.quantities import BodyVelocity, Pose


@pytest.mark.parametrize(('name', 'sides', 'fastest'), drawn(
    BASES, [(2.8, 2.8), (2.8, 6.0), (6.0, 3.5)], [(0.7, 1.5), (0.2, 0.5)], seed=4))
def test_a_base_stays_in_the_box_and_meets_most_manoeuvres(name, sides, fastest):
    area, state, homing = Area(*sides, BodyVelocity(*fastest)), Excited(), 0
    commands = []

    def control(time, _stamp, pose, velocity):
        nonlocal state, homing
        state, command = excite(state, time, Pose(*pose), BodyVelocity(*velocity), area)
        homing += state.is_homing
        commands.append(command)
        return command

    poses = [pose for _, pose in drive(BASES[name], control, (0.0, 0.0, 0.0), 60.0, 20.0)]
    assert all(area.holds(x, y) for x, y, _ in poses)
    assert homing < 0.25 * len(poses)
    assert state.number > 30
    for n in (0, 1):
        assert max(command[n] for command in commands) == pytest.approx(fastest[n])
        assert min(command[n] for command in commands) == pytest.approx(-fastest[n])
