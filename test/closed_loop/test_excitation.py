"""An excitation stays in its box, comes to all of its manoeuvres, and ends where odometry cannot be right."""

import math

import pytest
from helpers.drawn import drawn
from helpers.promising import BASES
from helpers.stand_in_model import drive

from mobile_robot_control.excitation.excitation import Agreement, Area, Excited, excite
from mobile_robot_control.quantities import BodyVelocity, Pose

RATE = 20.0


class Excitation:
    """Commands a base as `excite` does; `distort` changes a pose that odometry shows from a time [s] on."""

    def __init__(self, area, distort=lambda pose, time: pose):
        self.area, self._distort = area, distort
        self.state, self._agreement, self.commands, self.fault, self.homing = Excited(), Agreement(), [], '', 0
        self._before, self._told, self._stamp = None, BodyVelocity(0.0, 0.0), 0.0

    def __call__(self, time, stamp, pose, velocity):
        if self.fault:
            return 0.0, 0.0
        seen = self._distort((*pose, *velocity), time)
        self._agreement = self._agreement.commanded(
            self._told, BodyVelocity(*(self._before or seen)[3:]), 1.0 / RATE, self.area)
        if self._before not in (None, seen):
            self._agreement = self._agreement.moved(
                math.dist(seen[:2], self._before[:2]), abs(seen[2] - self._before[2]), stamp - self._stamp, self.area)
        self._before, self._stamp = seen, stamp
        self.fault = self._agreement.fault()
        self.state, self._told = excite(self.state, time, Pose(*seen[:3]), BodyVelocity(*seen[3:]), self.area)
        self.homing += self.state.is_homing
        self.commands.append(self._told)
        return self._told


@pytest.mark.parametrize(('name', 'sides', 'fastest'), drawn(
    BASES, [(2.8, 2.8), (2.8, 6.0), (6.0, 3.5)], [(0.7, 1.5), (0.2, 0.5)], seed=4))
def test_a_base_stays_in_the_box_and_meets_most_manoeuvres(name, sides, fastest):
    area = Area(*sides, BodyVelocity(*fastest))
    excitation = Excitation(area)
    poses = [pose for _, pose in drive(BASES[name], excitation, (0.0, 0.0, 0.0), 60.0, RATE)]
    assert not excitation.fault
    assert all(area.holds(x, y) for x, y, _ in poses)
    assert excitation.homing < 0.25 * len(poses)
    assert excitation.state.number > 30
    for n in (0, 1):
        assert max(command[n] for command in excitation.commands) == pytest.approx(fastest[n])
        assert min(command[n] for command in excitation.commands) == pytest.approx(-fastest[n])


class Frozen:
    """Odometry that stays as it is from a time [s] on."""

    def __init__(self, since):
        self._since, self._kept = since, None

    def __call__(self, seen, time):
        if time < self._since or self._kept is None:
            self._kept = seen
        return self._kept


@pytest.mark.parametrize('since', [0.0, 0.6, 7.7, 11.3, 21.4])
def test_a_base_stays_in_the_box_when_its_odometry_freezes(since):
    for name, base in BASES.items():
        area = Area(2.8, 2.8, BodyVelocity(0.7, 1.5))
        excitation = Excitation(area, Frozen(since))
        poses = [pose for _, pose in drive(base, excitation, (0.0, 0.0, 0.0), since + 16.0, RATE)]
        assert 'odometry does not change, though' in excitation.fault, name
        assert all(area.holds(x, y) for x, y, _ in poses), name


@pytest.mark.parametrize(('distort', 'is_fault'), [
    (lambda seen, time: (seen[0] + 0.36 * (time > 9.0), *seen[1:]), True),
    (lambda seen, time: (*seen[:2], seen[2] - 0.8 * (time > 9.0), *seen[3:]), True),
    # a second source, here and there
    (lambda seen, time: (seen[0] + 0.15 * (time > 9.0 and time * RATE % 2 < 1.0), *seen[1:]), True),
    # noise, and a small correction
    (lambda seen, time: (seen[0] + 0.003 * math.sin(1e3 * time), *seen[1:]), False),
    (lambda seen, time: (seen[0] + 0.1 * (time > 9.0), *seen[1:]), False),
])
def test_odometry_that_commands_cannot_explain_is_a_fault(distort, is_fault):
    excitation = Excitation(Area(2.8, 2.8, BodyVelocity(0.5, 1.5)), distort)
    drive(BASES['stand-in'], excitation, (0.0, 0.0, 0.0), 20.0, RATE)
    assert ('it jumps, or is of something else' in excitation.fault) == is_fault
