"""Requested excitations, and the area of the robot in one."""

from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.excitation.excitation import STOPPING, Area
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.parameters.requests import Reader
from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.runs.bag import Topics
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.files import read_namespace
from mobile_robot_control.system.files import encodable_path

_ROOM = 2.0
"""Half sides of the box, in stopping distances: one to drive, one to stop."""


class ExcitationRequest(NamedTuple):
    """The request of an excitation."""

    sources: ParameterSources
    box: Annotated[tuple[float, ...], Field('m', 'free floor: length along the robot and width; the robot starts in '
                                            'the middle', above=0.0, length=2)]
    max_velocity: Annotated[float, Field(
        'm/s', 'largest command; only commands beyond the limits of the robot show these', above=0.0)] = 0.2
    max_angular_velocity: Annotated[float, Field('rad/s', 'largest command', above=0.0)] = 1.0
    duration: Annotated[float, Field('s', 'wall time of the drive', minimum=10.0)] = 60.0
    rate: Annotated[float, Field('Hz', 'rate of the commands: the rate of your later runs', minimum=5.0,
                                 maximum=200.0)] = 50.0
    bag: Annotated[str | None, Field('', 'new bag for cmd_vel, odom, joint_states, wheel_torques and ground_truth; '
                                     'without it, record them yourself'), Reader(encodable_path, 'DIR')] = None
    namespace: Annotated[str, Field('', 'namespace of the robot'), Reader(read_namespace, 'NS')] = '/'
    topic: Topics = ()


def area_of(request: ExcitationRequest) -> Area:
    """Return the area of the robot; raise ParameterError if it could not stop there, or the bag exists."""
    if request.bag and Path(request.bag).exists():
        raise ParameterError([f'--bag {request.bag}: it is there already; name a new one'])
    needed = 2.0 * _ROOM * STOPPING * request.max_velocity
    if min(request.box) < needed:
        raise ParameterError([
            f'box = {request.box[0]:g} {request.box[1]:g} m is too small for max_velocity = {request.max_velocity:g} '
            f'm/s, at which a robot may need {STOPPING * request.max_velocity:g} m to stop: take sides of '
            f'{needed:g} m, or a max_velocity of {min(request.box) / needed * request.max_velocity:.3g} m/s'])
    ahead, aside = request.box
    return Area(ahead, aside, BodyVelocity(request.max_velocity, request.max_angular_velocity))
