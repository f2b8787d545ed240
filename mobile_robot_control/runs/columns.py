"""The columns of each topic of a run, and the conversion of messages and samples to them, and back."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from mobile_robot_control.loop.closed_loop import PositionTick, Sample
from mobile_robot_control.messages.topic_forms import columns_reader
from mobile_robot_control.quantities import (
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.topics import GROUND_TRUTH, RUN_TOPICS

TRUE_ERROR = 'true_error'
COLUMNS = {**{name: topic.columns for name, topic in RUN_TOPICS.items()},
           TRUE_ERROR: RUN_TOPICS['tracking_error'].columns}
"""The topics of a run; and the true error, if it differs from `tracking_error`, which no topic carries."""
READ = {topic: columns_reader(topic) for topic in RUN_TOPICS}
"""Reads a message of each topic into its COLUMNS."""
Numbers = Mapping[str, Sequence[float]]
"""By topic, in the order of its COLUMNS."""


class Held(NamedTuple):
    """The part of a sample that holds until the next position tick."""

    tick: PositionTick
    command: BodyVelocity
    truth: Truth | None


def numbers_of(sample: Sample) -> dict[str, Sequence[float]]:
    """Return the numbers of a sample by topic; with the truth if it is known."""
    tick, truth = sample.tick, sample.truth
    numbers: dict[str, Sequence[float]] = {
        'joint_states': (sample.right_angle, sample.left_angle, *sample.wheels, *sample.applied),
        'wheel_torques': sample.torque,
        'odom': (*tick.pose, *tick.velocity),
        'reference': (*tick.reference.pose, *tick.reference.velocity),
        'cmd_vel': sample.command,
        'tracking_error': tick.error,
    }
    if truth is not None:
        numbers[GROUND_TRUTH] = (*truth.pose, *truth.velocity)
        numbers[TRUE_ERROR] = truth.error
    return numbers


def held_of(time: float, numbers: Numbers) -> Held:
    """Return what holds from a position tick at a time [s] on; see `numbers_of`."""
    odom, reference = numbers['odom'], numbers['reference']
    tick = PositionTick(time, Pose(*odom[:3]), BodyVelocity(*odom[3:]),
                        Reference(Pose(*reference[:3]), BodyVelocity(*reference[3:])),
                        TrackingError(*numbers['tracking_error']))
    motion = numbers.get(GROUND_TRUTH)
    truth = None if motion is None else Truth(
        Pose(*motion[:3]), BodyVelocity(*motion[3:]), TrackingError(*numbers[TRUE_ERROR]))
    return Held(tick, BodyVelocity(*numbers['cmd_vel']), truth)


def sample_of(time: float, held: Held, numbers: Numbers) -> Sample:
    """Return the sample of a time [s]; see `numbers_of`."""
    tick, command, truth = held
    joints = numbers['joint_states']
    return Sample(time, tick, command, joints[0], joints[1], WheelVelocity(*joints[2:4]), WheelTorque(*joints[4:]),
                  WheelTorque(*numbers['wheel_torques']), truth)
