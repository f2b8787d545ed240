"""`identify`: a robot's parameters from its bags."""

from collections.abc import Mapping, Sequence
from os import PathLike, fspath

from mobile_robot_control.identification.engine import IdentificationRequest
from mobile_robot_control.identification.engine import identify as identify_request
from mobile_robot_control.identification.result import Identification
from mobile_robot_control.parameters.requests import make_request
from mobile_robot_control.settings.configure import File, parameter_sources
from mobile_robot_control.settings.provenance import call_text


def identify(
    bags: File | Sequence[File], *files: File, robot: File | None = None,
    parameters: Mapping[str, object] | None = None, namespace: str = '/', topics: Mapping[str, str] | None = None,
    same_clock: bool = False,
) -> Identification:
    """
    Identify a robot from its bags, as the command `identify` does, to the same numbers.

    Parameters
    ----------
    bags : path, or sequence of path
        Recordings of one robot.
    *files : path
        ROS 2 parameter files, later ones win: known parameters of the robot, such as its wheels.
    robot : str or path or None
        A robot of this package, or the parameter file of one.
    parameters : mapping of str to object or None
        Values by ``NODE.PARAMETER``, which win over the files.
    namespace : str
        Of the nodes.
    topics : mapping of str to str or None
        Other names of topics of the loop, or of ``ground_truth``, in the bags.
    same_clock : bool
        Whether a single clock stamped commands and odometry, and recorded both.

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
    return identify_request(request, call)
