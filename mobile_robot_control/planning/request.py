"""Requested plans of paths, and `plan`."""

from collections.abc import Mapping
from os import fspath
from typing import Annotated, NamedTuple

from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.parameters.requests import Reader, takes_fields
from mobile_robot_control.planning.planning import Plan, plan_of
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.settings.configure import File, ParameterSources, parameter_sources
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.settings.provenance import call_text


class PlanRequest(NamedTuple):
    """The request to plan a path."""

    sources: ParameterSources
    file: Annotated[str, Field('', 'CSV or YAML file of waypoints: x, y [m] and an optional speed [m/s]'),
                    Reader(fspath, 'FILE')]

    def configuration(self) -> Configuration:
        """Return the configuration of a run along the path."""
        return self.sources.with_values(
            {'reference_cart.curve': PATH, 'reference_cart.path.file': self.file}).configuration()


def make_plan(request: PlanRequest, command_line: str) -> Plan:
    """Plan the path of a request; raise ParameterError if it is infeasible."""
    return plan_of(request.configuration(), command_line)


@takes_fields(PlanRequest)
def plan(
    file: File, *files: File, robot: File | None = None, parameters: Mapping[str, object] | None = None
) -> Plan:
    r"""
    Plan the fastest motion along a path of waypoints, as the command `plan` does, without driving it.

    Parameters
    ----------
    *files : path
        ROS 2 parameter files, later ones win.
    robot : str or path or None
        A robot of this package, or the parameter file of one.
    parameters : mapping of str to object or None
        Values by ``NODE.PARAMETER``, which win over the files: ``reference_cart.timing.*`` and
        ``reference_cart.path.*``.

    Returns
    -------
    Plan
        The motion, with the active limit at each point.

    Raises
    ------
    ParameterError
        With every violation; those of the file have their line.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import mkdtemp
    >>> file = Path(mkdtemp(), 'line.csv')
    >>> _ = file.write_text('0, 0\n1, 0\n')
    >>> limits = {'max_linear_velocity': 0.5, 'max_linear_acceleration': 1.0}
    >>> plan(file, parameters={f'reference_cart.timing.{name}': value for name, value in limits.items()})
    <Plan: 1 m in 2.5 s; active: linear velocity 60%, linear acceleration 40%>

    """
    request = PlanRequest(parameter_sources(files, robot, parameters), fspath(file))
    return make_plan(request, call_text('plan', file, *files, robot=robot, parameters=parameters))
