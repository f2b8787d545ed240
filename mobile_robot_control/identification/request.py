"""`identify`: a robot's parameters, with intervals, from its bags."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from mobile_robot_control.identification import findings
from mobile_robot_control.identification.judgement import with_judgement
from mobile_robot_control.identification.recorded import Recorded, read_recorded
from mobile_robot_control.identification.result import Identification, UnidentifiableError
from mobile_robot_control.identification.torque_robot import identify_torques
from mobile_robot_control.identification.velocity_robot import identify_base
from mobile_robot_control.messages.bag_messages import BagError, ProgressCallback
from mobile_robot_control.model.plant import VELOCITY
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.parameters.requests import Reader, make_request, takes_fields
from mobile_robot_control.runs.bag import Topics, topic_names
from mobile_robot_control.settings.configure import File, ParameterSources, parameter_sources
from mobile_robot_control.settings.files import read_namespace
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.settings.provenance import call_text, provenance
from mobile_robot_control.system.texts import missing


class IdentificationRequest(NamedTuple):
    """The request of an identification."""

    sources: ParameterSources
    bags: Annotated[tuple[str, ...], Field('', 'bags of one robot, mcap or sqlite3, or folders of `experiment`'),
                    Reader(fspath, 'BAG')]
    namespace: Annotated[str, Field('', 'namespace of the nodes in the bags'), Reader(read_namespace, 'NS')] = '/'
    topic: Topics = ()
    same_clock: Annotated[bool, Field('', 'one clock stamped and recorded commands and odometry: separate dead time '
                                      'from latency')] = False


class Recordings(NamedTuple):
    """The recordings read, and the robot's kind of command in them."""

    recordings: list[Recorded]
    configuration: Configuration
    takes_velocity: bool
    lacks: list[findings.Lack]

    @property
    def problems(self) -> list[str]:
        """What could not be read, after the name of its bag."""
        return [f'{one.name}: {problem}' for one in self.recordings for problem in one.problems]


def read_inputs(request: IdentificationRequest, progress: ProgressCallback = lambda *_: None) -> Recordings:
    """Read the recordings of a request; raise ParameterError if one cannot be read."""
    configuration = request.sources.configuration(request.namespace)
    topics, recordings, problems = topic_names(request.topic), [], []
    for bag in request.bags:
        try:
            recordings += read_recorded(Path(bag), request.namespace, topics, progress)
        except BagError as error:
            problems.append(str(error))
    if problems:
        raise ParameterError(problems)
    has_effort = any(one.torques and np.isfinite(one.torques.values).any() for one in recordings)
    has_commands = any(one.commands and one.motion for one in recordings)
    takes_velocity = configuration.plant.model.drive == VELOCITY or (
        not has_effort and (has_commands or not any(one.wheels for one in recordings)))
    return Recordings(recordings, configuration, takes_velocity, findings.lacks(recordings, takes_velocity))


def identified(
    request: IdentificationRequest, command_line: str, tell: Callable[[], object] = lambda: None,
    progress: ProgressCallback = lambda *_: None,
) -> Identification:
    """
    Identify the robot of a request.

    Parameters
    ----------
    request : IdentificationRequest
        Checked.
    command_line : str
        Recorded with the result.
    tell, progress : callable
        Called during the search, and with the progress of the reading.

    Raises
    ------
    ParameterError
        If a bag cannot be read, or SciPy is missing.
    UnidentifiableError
        If the recordings contain no usable information.
    """
    _need_scipy()
    inputs = read_inputs(request, progress)
    vital = [str(lack) for lack in inputs.lacks if lack.is_vital]
    if vital:
        raise UnidentifiableError(vital)
    result = (identify_base(inputs.recordings, inputs.configuration, request.same_clock, tell) if inputs.takes_velocity
              else identify_torques(inputs.recordings, inputs.configuration, tell))
    if not result.parameters:
        raise UnidentifiableError([*result.open, *result.lacking])
    return with_judgement(result, any(lack.contradicts for lack in inputs.lacks))._replace(
        open=(*map(str, inputs.lacks), *result.open),
        notes=(*result.notes, *inputs.problems),
        provenance=provenance(command_line, inputs.configuration))


def _need_scipy() -> None:
    try:
        import scipy  # noqa: F401, PLC0415 (asked for before a long reading)
    except ModuleNotFoundError as error:
        raise ParameterError([missing(error.name, 'identify')]) from None


@takes_fields(IdentificationRequest)
def identify(
    bags: File | Sequence[File], *files: File, robot: File | None = None,
    parameters: Mapping[str, object] | None = None, namespace: str = '/', topics: Mapping[str, str] | None = None,
    same_clock: bool = False,
) -> Identification:
    """
    Identify a robot from its bags, as the command `identify` does, to the same numbers.

    Parameters
    ----------
    *files : path
        ROS 2 parameter files, later ones win: known parameters of the robot, such as its wheels.
    robot : str or path or None
        A robot of this package, or the parameter file of one.
    parameters : mapping of str to object or None
        Values by ``NODE.PARAMETER``, which win over the files.
    topics : mapping of str to str or None
        Other names of topics of the loop, or of ``ground_truth``, in the bags.

    Returns
    -------
    Identification
        Parameters with 95 % intervals and their covariance, and open questions.

    Raises
    ------
    ParameterError
        If a bag cannot be read, or SciPy is missing.
    UnidentifiableError
        If the recordings contain no usable information; it has the reasons.

    Examples
    --------
    >>> identify('no_such_bag')
    Traceback (most recent call last):
    mobile_robot_control.parameters.declaration.ParameterError: no_such_bag: does not exist; name a bag that ...

    """
    several = [bags] if isinstance(bags, str | PathLike) else list(bags)
    request = make_request(IdentificationRequest, {
        'sources': parameter_sources(files, robot, parameters), 'bags': tuple(map(fspath, several)),
        'namespace': namespace, 'topic': dict(topics or {}), 'same_clock': same_clock})
    call = call_text('identify', bags, *files, robot=robot, parameters=parameters,
                     namespace=None if namespace == '/' else namespace, topics=topics, same_clock=same_clock or None)
    return identified(request, call)
