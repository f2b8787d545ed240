"""Paths with stretches backwards and turns on the spot: every law follows them as it follows a path forwards."""

import math

import pytest
from helpers.measuring import selecting
from helpers.stand_in_model import Base, drive

from mobile_robot_control.control import bumpless_transfer
from mobile_robot_control.control.compensation import carried_forward
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import course_of

LIMITS = ['max_linear_velocity:=0.4', 'max_linear_acceleration:=0.4', 'max_angular_velocity:=1.2',
          'max_angular_acceleration:=2.5']
FED = '/**.feedforward.enabled:=true'
RATE = 50.0
BASE = Base(dead_zone=0.0)
# [cm] RMS; the seeking rotation of the hybrid law at its start does not count
MOST = {'dynamic_feedback_linearization': 2.5}

# of static laws without table or memory kanayama, ramsete and periodic stand for the others
DRIVEN = pytest.mark.parametrize('law', [
    pytest.param(law, marks=pytest.mark.soak) if law in ('input_output_linearization', 'stanley') else law
    for law in LAWS])


def configured(file, law, *more):
    return configure(load([], [
        'reference_cart.curve:=path', f'reference_cart.path.file:={file}', 'reference_cart.path.turn_back:=reverse',
        *(f'reference_cart.timing.{limit}' for limit in LIMITS), *selecting(law, int(FED in more)).items(), *more]))


def arcs(*legs, gap=0.05):
    """Return the poses on arcs of a length [m] and a turn [rad], backwards where the length is negative."""
    x = y = heading = 0.0
    poses = [(x, y, heading)]
    for length, turn in legs:
        parts = round(abs(length) / gap) or 5
        for _ in range(parts):
            heading += 0.5 * turn / parts
            x, y = x + length / parts * math.cos(heading), y + length / parts * math.sin(heading)
            heading += 0.5 * turn / parts
            poses.append((x, y, heading))
    return poses


def write(file, poses):
    file.write_text('\n'.join(['x,y,heading', *(','.join(f'{number:.6f}' for number in pose) for pose in poses)]))
    return file


TWO_CUSPS = arcs((1.5, 0.9), (-1.15, 0.9), (1.95, 0.6))
ON_THE_SPOT = arcs((1.0, 0.0), (0.0, math.pi / 2.0), (1.0, 0.0), gap=0.1)


@DRIVEN
def test_a_stretch_backwards_is_the_one_forwards_mirrored(tmp_path, law):
    forwards = arcs((1.5, 0.9), (1.0, -0.6))
    backwards = [(x, y, heading + math.pi) for x, y, heading in forwards]
    commands = []
    for sign, poses, heading in ((1.0, forwards, 0.1), (-1.0, backwards, math.pi + 0.1)):
        made = configured(write(tmp_path / f'{sign}.csv', poses), law, f'plant.initial_pose:=[-0.02, 0.05, {heading}]')
        course = course_of(made.reference_cart)
        assert [part.backward for part in course.parts] == [sign < 0.0]
        commands.append([(sign * one.command.linear, one.command.angular) for one in rollout(made, course.period)])
    ours, theirs = commands
    assert all(one == pytest.approx(other, abs=1e-9) for one, other in zip(ours, theirs, strict=True))
    assert max(v for v, _ in ours) > 0.3


def errors_on(course, control, base=BASE):
    """Return the distances from the reference of a base that a law drives, tick by tick [m], and its last error."""
    references = []

    def command(time, stamp, pose, velocity):
        references.append(course.accelerated(time))
        return control(references[-1], time - stamp, Pose(*pose), BodyVelocity(*velocity))

    truth = drive(base, command, course.reference(0.0).pose, course.period + 2.0, RATE)
    errors = [tracking_error(one.pose, Pose(*pose)) for one, (_, pose) in zip(references, truth, strict=True)]
    return [math.hypot(*error[:2]) for error in errors], errors[-1]


class Control:
    """A law with the lead of a base's lag, and with compensated latency."""

    def __init__(self, law):
        control = configure(load([], selecting(law).items())).position_controller.control
        late = control.feedforward._replace(lag=(BASE.lag,) * 2, dead_time=(0.5 / BASE.command_rate,) * 2)
        control = control._replace(feedforward=late)
        self._law = bumpless_transfer.begin_law(control, 1.0 / RATE, under_way=False)

    def __call__(self, reference, age, pose, velocity):
        error = tracking_error(reference.pose, carried_forward(pose, velocity, age))
        self._law, command = bumpless_transfer.step(
            self._law, Observation(error, reference, velocity), 1.0 / RATE, reference.acceleration)
        return command


def judged(distances, law, rate):
    """Return the RMS of distances [cm], of the hybrid law after its search for the cart."""
    kept = distances[round(4.0 * rate):] if law == 'hybrid_backstepping' else distances
    return 100.0 * math.sqrt(sum(one * one for one in kept) / len(kept))


@DRIVEN
@pytest.mark.parametrize('poses', [TWO_CUSPS, ON_THE_SPOT], ids=['two cusps', 'on the spot'])
def test_robot_and_base_follow_cusps_as_well_as_turns_on_the_spot(tmp_path, law, poses):
    made = configured(write(tmp_path / 'path.csv', poses), law, 'plant.initial_pose:=[0.0, 0.0, 0.0]', FED)
    course = course_of(made.reference_cart)
    assert sum(part.backward for part in course.parts[::2]) == (poses is TWO_CUSPS)
    samples = [one for one in rollout(made, course.period + 2.0) if one.tick.time == one.time]
    robot = [math.hypot(*one.tick.error[:2]) for one in samples], samples[-1].tick.error
    for rate, (distances, last) in ((100.0, robot), (RATE, errors_on(course, Control(law)))):
        assert judged(distances, law, rate) < (10.0 if law == 'fuzzy' else MOST.get(law, 2.0))
        assert math.hypot(*last[:2]) < 0.035
        assert abs(last.heading) < math.radians(2.0)
