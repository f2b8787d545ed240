"""A base that stands elsewhere, or is held for 6 s, comes back to the cart no faster than the lap itself."""

import itertools
import math

import pytest
from helpers.drawn import drawn
from helpers.following import PARAMETERS, Following
from helpers.stand_in_model import Base, drive

from mobile_robot_control.control.laws import BUILT_IN

LAWS = ['backstepping', 'hybrid_backstepping', 'fuzzy']
FAST = Base(fastest=5.0)
"""A base that hides no command that is too fast."""
FROM, HELD = 10.0, 6.0
"""[s]"""


def speeds(truth, begin=0.0):
    """Return the speeds of a base [m/s] from a time on."""
    return [math.hypot(after[0] - before[0], after[1] - before[1]) / (then - now)
            for (now, before), (then, after) in itertools.pairwise(truth) if now >= begin]


def held(following):
    """Return a control whose commands the base does not get for a while, as in an emergency stop of its own."""
    def control(time, *seen):
        command = following(time, *seen)
        return (0.0, 0.0) if FROM <= time < FROM + HELD else command
    return control


@pytest.mark.parametrize(('law', 'place'), drawn(LAWS, [
    (1.0, -1.5, math.pi), (2.5, 0.0, 1.5), (-0.5, 0.0, 0.0), (1.0, 1.5, -1.5)]))
def test_from_anywhere_the_robot_drives_to_the_cart_at_bounded_speed_and_follows_it(law, place):
    speed = PARAMETERS.position_controller.approach.speed
    following = Following(law, speed)
    truth = drive(Base(), following, place, 24.0)
    waited = following.waited
    # the whole way at the speed of the approach, with three turns on the spot
    assert 1.4 / speed < waited * 0.02 < 1.4 / speed + 12.0
    assert max(abs(command.linear) for command in following.commands[:waited]) <= speed
    assert max(abs(command.angular) for command in following.commands[:waited]) <= 4.0 * speed
    # while it drives, the cart waits at its start; then it does not wait again
    assert following.times[waited - 1] == 0.0 < following.times[waited]
    assert following.apart[waited] < 0.15
    assert max(following.apart[-200:]) < (0.2 if law == 'fuzzy' else 0.06)
    # the lap's own speed is 0.59 m/s at most
    assert max(speeds(truth)) < 0.71


@pytest.mark.parametrize(('law', 'approach_speed'), drawn(LAWS, [0.0, 0.2]))
def test_a_base_that_was_held_is_not_made_to_chase_the_cart(law, approach_speed):
    following = Following(law, approach_speed)
    truth = drive(FAST, held(following), following.reference(0.0).pose, 36.0)
    usual = max(speeds(truth[:int(FROM * 50)]))
    assert max(speeds(truth, FROM + HELD)) < 1.15 * usual
    assert max(following.apart[-200:]) < (0.2 if law == 'fuzzy' else 0.06)
    assert 5.0 < following.waited * 0.02 < 10.0
    # the reference never jumps
    assert max(after - before for before, after in itertools.pairwise(following.times)) < 0.021


@pytest.mark.parametrize(('law', 'approach_speed'), [
    pytest.param(law.name, speed, marks=() if (law.name, speed) in (('kanayama', 0.2), ('fuzzy', 0.0)) else
                 pytest.mark.soak) for law in BUILT_IN for speed in (0.0, 0.2)])
def test_a_base_that_starts_late_is_turned_along_the_curve_first_if_it_may_approach(law, approach_speed):
    following = Following(law, approach_speed)
    start, errors = following.reference(0.0).pose, []

    def late(time, stamp, pose, velocity):
        command = following(time, stamp, pose, velocity)
        errors.append(abs(math.remainder(pose[2] - start.heading, 2.0 * math.pi)))
        return command if time > 2.0 else (0.0, 0.0)

    drive(Base(), late, (start.x + 0.03, start.y, start.heading + 3.1), 16.0)
    began = next((n for n, time in enumerate(following.times) if time > 0.0), None)
    if (law, approach_speed) == ('input_output_linearization', 0.0):
        # nothing turns it: its point ahead is that of the cart, but for the dead zone, its axle on the other side of it
        distance = PARAMETERS.position_controller.control.input_output_linearization.distance
        assert began is None
        assert 1.8 * distance < following.apart[-1] < 2.0 * distance
        return
    assert errors[began] < 0.3 or not approach_speed
    assert max(following.apart[-100:]) < (0.2 if law == 'fuzzy' else 0.1)


def test_an_approach_is_not_stopped_for_its_distance_and_a_law_that_would_leap_is():
    law, place = 'fuzzy', (1.0, -1.5, 0.0)
    approaching = Following(law, 0.2, limit=0.3)
    drive(Base(), approaching, place, 16.0)
    assert not approaching.drive._stop.reason
    assert approaching.apart[-1] < 0.2
    leaping = Following(law, 0.0, limit=0.3)
    drive(Base(), leaping, place, 1.0)
    assert '1.50 m from the reference, and limits.tracking_error is 0.3 m' in leaping.drive._stop.reason
    assert set(leaping.commands) == {(0.0, 0.0)}


def test_an_approach_that_leads_away_is_stopped():
    """As with odometry whose heading is reversed."""
    following = Following('backstepping', 0.2, limit=0.3)

    def reversed_base(time, stamp, pose, velocity):
        return following(time, stamp, (*pose[:2], pose[2] + math.pi), velocity)

    drive(Base(), reversed_base, (1.0, -1.5, 0.0), 16.0)
    assert 'from the reference' in following.drive._stop.reason
    stopped = next(n for n, command in enumerate(following.commands) if n > 5 and command == (0.0, 0.0))
    assert following.apart[stopped] == pytest.approx(1.8, abs=0.01)
