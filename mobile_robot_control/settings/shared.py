"""The parameters shared by all four nodes."""

import math
from collections.abc import Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import Field, rule
from mobile_robot_control.quantities import FASTEST, NANOSECONDS, period_nanoseconds

SENT, SAMPLED = 'sent', 'sampled'
ODOM = 'odom'
"""Value of `path_frame`: the frame of odometry, whatever its name is."""


class FeedforwardSwitch(NamedTuple):
    """The switch for feedforward of the reference's acceleration."""

    enabled: Annotated[
        bool, Field('', "feed the reference's acceleration forward: the command leads by feedforward.lag and "
                        'feedforward.dead_time, and wheel torques contain the inverse dynamics of robot; needs '
                        'reference_horizon >= 1')
    ] = False


class Shared(NamedTuple):
    """Parameters shared by all four nodes."""

    robot: Robot = Robot()
    velocity_rate: Annotated[
        float, Field('Hz', 'rate of the plant and the velocity loop, with a period of whole nanoseconds: larger allows '
                     'larger velocity gains and costs more CPU', minimum=0.001, maximum=FASTEST)
    ] = 500.0
    position_rate: Annotated[
        float, Field('Hz', 'rate of the position loop, a divisor of velocity_rate: larger makes smaller steps of the '
                     'command', minimum=0.001, maximum=FASTEST)
    ] = 100.0
    lockstep: Annotated[
        bool, Field('', 'true: simulated time waits for every node; false: each node runs on its own wall clock')
    ] = True
    peer_timeout: Annotated[
        float, Field('s', 'wall time after which a node reports that an input is missing', above=0.0)
    ] = 2.0
    stamp_tolerance: Annotated[
        float, Field('s', 'wall clock: largest difference of a stamp from now; other messages are refused', above=0.0)
    ] = 0.5
    stamped_cmd_vel: Annotated[
        bool, Field('', 'false: cmd_vel is a plain Twist, for bases that take no other (on the wall clock alone)')
    ] = True
    odometry_stamped: Annotated[
        str, Field('', 'time of the stamp of odom: sent, when the base sends it, or sampled, when it measures; with '
                       'sampled, a controller that compensates latency knows its age', choices=(SENT, SAMPLED))
    ] = SENT
    reference_horizon: Annotated[
        int, Field('', "position ticks ahead with the cart's pose, velocity and acceleration on reference_horizon, 0 "
                       'for none: larger lets a law look farther ahead', minimum=0, maximum=1000)
    ] = 0
    feedforward: FeedforwardSwitch = FeedforwardSwitch()
    odom_frame_id: Annotated[str, Field('', 'frame of odometry and reference')] = 'odom'
    path_frame: Annotated[
        str, Field('', f'frame of paths, curves and goals: {ODOM}, that of odometry, or another one, such as map, from '
                       'which /tf and /tf_static lead to it')
    ] = ODOM
    base_frame_id: Annotated[str, Field('', "frame of the robot, at the axle's centre")] = 'base_link'
    reference_frame_id: Annotated[str, Field('', 'frame of the reference cart')] = 'reference_cart'

    @property
    def stamps_samples(self) -> bool:
        """Whether odom carries the time of its sampling as its stamp."""
        return self.odometry_stamped == SAMPLED

    @property
    def path_frame_id(self) -> str:
        """Frame of paths, curves and goals."""
        return self.odom_frame_id if self.path_frame == ODOM else self.path_frame

    @property
    def is_localised(self) -> bool:
        """Whether a localisation leads from that frame to odometry."""
        return self.path_frame_id != self.odom_frame_id

    @property
    def has_odom_time(self) -> bool:
        """Whether a separate message carries it: in lockstep the stamp of odom is that of the question."""
        return self.lockstep and self.stamps_samples


def _whole_nanoseconds(rate: float) -> bool:
    """Return whether the period of a rate [Hz] is whole nanoseconds."""
    period = period_nanoseconds(rate)
    return period >= 1 and math.isclose(period * rate, NANOSECONDS, rel_tol=1e-12)


@rule
def _rates_divide(shared: Shared) -> Iterator[str]:
    rates = {'velocity_rate': shared.velocity_rate, 'position_rate': shared.position_rate}
    for name, rate in rates.items():
        if not _whole_nanoseconds(rate):
            near = NANOSECONDS / max(1, period_nanoseconds(rate))
            yield (f'{name} = {rate} Hz has a period of {NANOSECONDS / rate:.3f} ns; stamps need whole nanoseconds: '
                   f'the nearest rate is {near!r} Hz')
    if all(_whole_nanoseconds(rate) for rate in rates.values()):
        ratio = shared.velocity_rate / shared.position_rate
        if period_nanoseconds(shared.position_rate) % period_nanoseconds(shared.velocity_rate):
            lower, upper = math.floor(ratio), math.ceil(ratio)
            choices = ' or '.join(repr(shared.velocity_rate / n) for n in (upper, lower) if n)
            yield (f'position_rate = {shared.position_rate} Hz does not divide velocity_rate = '
                   f'{shared.velocity_rate} Hz; take {choices} Hz')


@rule
def _lockstep_needs_stamps(shared: Shared) -> Iterator[str]:
    if shared.lockstep and not shared.stamped_cmd_vel:
        yield ('stamped_cmd_vel = False needs lockstep = False: in lockstep stamps decide; '
               'set lockstep to false, or leave cmd_vel stamped')


@rule
def _feedforward_needs_accelerations(shared: Shared) -> Iterator[str]:
    if shared.feedforward.enabled and shared.reference_horizon < 1:
        yield ("feedforward.enabled = True needs reference_horizon = 1 or more, which is 0; write both under '/**'")
