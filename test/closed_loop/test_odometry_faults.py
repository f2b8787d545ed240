"""Motion against the command: no run of a law on a curve looks like it, and a robot that turns the other way does."""

import math
import random
from itertools import pairwise

import pytest
from helpers.following import Following
from helpers.stand_in_model import LEVER, RADIUS, STEP, Base, StandIn, drive

import mobile_robot_control as mrc
from mobile_robot_control.control.odometry_faults import Opposition, jump_across
from mobile_robot_control.quantities import BodyVelocity, Pose

LAWS = ('backstepping', 'hybrid_backstepping', 'fuzzy', 'kanayama', 'ramsete', 'periodic',
        'dynamic_feedback_linearization', 'sliding_mode', 'lqr')
CURVES = ('trifolium', 'lemniscate', 'circle', 'lissajous')
DT = 0.02
SOAK = (pytest.mark.soak, pytest.mark.timeout(1800))


def faults(run):
    """Return what a controller would have told during a run."""
    state, every = Opposition(), max(1, round(DT / (run.time[1] - run.time[0])))
    pose, velocity, command = (one[::every].tolist() for one in (run.pose, run.velocity, run.cmd_vel))
    for n in range(1, len(pose)):
        state = state.after(
            BodyVelocity(*command[n - 1]), Pose(*pose[n - 1]), Pose(*pose[n]), BodyVelocity(*velocity[n]), DT)
        if state.fault():
            return state.fault()
    return ''


def unicycle(draw, turns):
    """Drive a unicycle with lag and dead time after a circle or an eight; return time and fault, if there is one."""
    lag, dead, way = draw.uniform(0.02, 0.6), draw.randint(0, 10), draw.choice((1.0, -1.0, 0.0))
    x, y, heading, v, omega, state = 0.0, draw.uniform(-0.5, 0.5), draw.uniform(-1.0, 1.0), 0.0, 0.0, Opposition()
    sent = [BodyVelocity(0.0, 0.0)] * (dead + 1)
    for n in range(round(12.0 / DT)):
        t = n * DT
        turn = way * 0.6 if way else 0.8 * math.sin(0.5 * t)
        at = Pose(0.3 * t, 0.0, 0.0) if not way else Pose(
            0.5 * math.sin(0.6 * t), way * 0.5 * (1.0 - math.cos(0.6 * t)), way * 0.6 * t)
        ex, ey = at.x - x, at.y - y
        e1, e2 = math.cos(heading) * ex + math.sin(heading) * ey, -math.sin(heading) * ex + math.cos(heading) * ey
        e3 = math.remainder(at.heading - heading, 2.0 * math.pi)
        sent.append(BodyVelocity(0.3 * math.cos(e3) + 1.0 * e1, (turn if way else 0.0) + 4.0 * e2 + 2.0 * math.sin(e3)))
        asked = BodyVelocity(*(max(-most, min(most, one)) for one, most in zip(
            sent[-1 - dead], (0.5, 1.5), strict=True)))
        v += (asked.linear - v) * (1.0 - math.exp(-DT / lag))
        omega += (turns * asked.angular - omega) * (1.0 - math.exp(-DT / lag))
        before = Pose(x, y, heading)
        x, y = x + DT * v * math.cos(heading), y + DT * v * math.sin(heading)
        heading += DT * omega
        state = state.after(sent[-1], before, Pose(x, y, heading), BodyVelocity(v, omega), DT)
        if state.fault():
            return t, state.fault()
    return 12.0, ''


@pytest.mark.parametrize(('law', 'curves', 'seconds'), [
    ('kanayama', CURVES[:1], 6.0), *(pytest.param(law, CURVES, 16.0, marks=pytest.mark.soak) for law in LAWS)])
def test_no_law_on_any_curve_looks_as_if_the_robot_moved_against_its_command(law, curves, seconds):
    for curve in curves:
        for start in ((0.0, 0.0, 0.0), (1.0, -0.7, 2.5), (-0.5, 0.8, -1.5)):
            run = mrc.simulate(duration=seconds, parameters={
                'position_controller.controller_type': law, 'reference_cart.curve': curve,
                'plant.initial_pose': list(start)})
            assert faults(run) == '', (curve, start)


def test_a_unicycle_that_turns_the_other_way_is_found_and_a_right_one_is_not():
    for seed in range(40):
        assert unicycle(random.Random(seed), 1.0) == (12.0, ''), seed  # noqa: S311 (a test)
        at, told = unicycle(random.Random(seed), -1.0)  # noqa: S311
        assert told, seed
        assert at < 8.0, seed


def draw_base(draw):
    """Draw a base with slip, lags, dead time, saturation and late, lost or rough messages."""
    of = draw.uniform
    return Base(
        command_rate=of(15.0, 50.0), odom_rate=of(10.0, 60.0), latency=of(0.0, 0.12), lag=of(0.02, 0.4),
        dead_time=of(0.0, 0.2), dead_zone=of(0.0, 0.05), fastest=of(0.3, 0.8),
        acceleration=draw.choice((math.inf, of(0.3, 2.0))), unlike=of(-0.05, 0.05), turn=of(0.7, 1.05),
        jitter=of(0.0, 0.03), lost=of(0.0, 0.1), ticks=draw.choice((0, 500, 4096)),
        second_lag=draw.choice((0.0, of(0.02, 0.15))), quantum=draw.choice((0.0, 0.01, 0.05)), scrub=of(0.0, 0.5),
        skid=of(0.0, 0.4))


class Handled(StandIn):
    """A base that hands push for up to half a second, and lift so that its wheels turn without moving it."""

    def __init__(self, base, pose, draw):
        super().__init__(base, pose)
        times = [draw.uniform(1.0, 15.0) for _ in range(5)]
        self.pushes = [(at, at + draw.uniform(0.1, 0.5), draw.uniform(-0.5, 0.5), draw.uniform(-1.5, 1.5))
                       for at in times[:3]]
        self.lifts = [(at, at + draw.uniform(0.3, 3.0)) for at in times[3:]]

    def _push(self):
        """Return the velocity by which it is pushed."""
        now = [push[2:] for push in self.pushes if push[0] <= self.k * STEP < push[1]]
        return now[0] if now else (0.0, 0.0)

    def _odometer(self):
        pose, (v, omega) = super()._odometer()
        more = (0.0, 0.0) if self.base.ticks else self._push()
        return pose, (v + more[0], omega + more[1])

    def move(self):
        """Move, and be moved."""
        (v, omega), at = self._push(), self.pose
        is_lifted = any(begin <= self.k * STEP < end for begin, end in self.lifts)
        super().move()
        x, y, heading = at if is_lifted else self.pose
        self.pose = (x + STEP * v * math.cos(heading), y + STEP * v * math.sin(heading), heading + STEP * omega)
        for wheel, side in enumerate((1.0, -1.0)):
            self._turned[wheel] += STEP * (v + side * LEVER * omega) / RADIUS


def judged(seed, swapped):
    """Drive a drawn base, also with swapped wheels; return whether a fault is told, and the way [m]."""
    draw = random.Random(seed)  # noqa: S311 (a simulation)
    base, law = draw_base(draw), draw.choice(LAWS)
    # unless it approaches the cart, a base with swapped wheels may spin beside it
    following = Following(law, 0.2 if swapped else draw.choice((0.0, 0.2)))
    x, y, heading = following.reference(0.0).pose
    place = (x + draw.uniform(-0.08, 0.08), y + draw.uniform(-0.08, 0.08), heading + draw.uniform(-1.5, 1.5))
    state, last, found, command = Opposition(), None, False, BodyVelocity(0.0, 0.0)

    def control(time, stamp, pose, velocity):
        nonlocal state, last, found, command
        if last is not None and stamp > last[0]:
            state = state.after(command, last[1], Pose(*pose), BodyVelocity(*velocity), stamp - last[0])
            found = found or bool(state.fault())
        last, command = (stamp, Pose(*pose)), following(time, stamp, pose, velocity)
        return (command.linear, -command.angular if swapped else command.angular)

    truth = drive(base, control, place, 16.0, made=StandIn if swapped else lambda *at: Handled(*at, draw))
    return found, math.fsum(math.dist(one[1][:2], other[1][:2]) for one, other in pairwise(truth))


@pytest.mark.parametrize('seeds', [range(5), pytest.param(range(5, 100), marks=SOAK)])
def test_no_drawn_base_that_slips_or_is_pushed_is_told_to_move_against_its_command(seeds):
    assert [seed for seed in seeds if judged(seed, swapped=False)[0]] == []


@pytest.mark.parametrize('seeds', [range(3), pytest.param(range(3, 60), marks=SOAK)])
def test_most_drawn_bases_with_swapped_wheels_are_found_and_others_do_not_get_far(seeds):
    answers = [judged(seed, swapped=True) for seed in seeds]
    assert [way for found, way in answers if not found and way > 2.0] == []
    assert sum(found for found, _ in answers) > 0.8 * len(answers)


def test_braking_and_a_measured_zero_are_not_against_the_command():
    # a robot that rolls back by itself for some time, ever slower
    state, pose = Opposition(), Pose(0.0, 0.0, 0.0)
    for n in range(200):
        speed = -0.6 * math.exp(-n * DT / 1.5)
        before, pose = pose, pose._replace(x=pose.x + DT * speed)
        state = state.after(BodyVelocity(0.4, 0.0), before, pose, BodyVelocity(speed, 0.0), DT)
        assert state.fault() == ''
    state = Opposition()
    for _ in range(500):
        state = state.after(BodyVelocity(0.4, 1.0), pose, pose, BodyVelocity(0.0, 0.0), DT)
    assert state.fault() == ''


def test_across_a_silence_a_pose_may_lie_as_far_as_commands_drive_until_they_time_out():
    at = Pose(1.0, 0.0, 3.1)
    fastest = BodyVelocity(0.4, 1.0)
    for silence, away, jumps in ((0.5, 0.29, False), (0.5, 0.31, True), (20.0, 0.69, False), (20.0, 0.71, True)):
        assert bool(jump_across(silence, at, at._replace(x=1.0 + away), fastest, 0.5)) is jumps
    assert jump_across(0.3, at, at._replace(heading=-3.1), fastest, 0.5) == ()
    assert jump_across(0.3, at, at._replace(heading=2.0), fastest, 0.5) == (0.0, pytest.approx(1.1))
