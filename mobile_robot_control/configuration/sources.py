"""The sources of a loop's parameters: a robot, files, and single values; later ones win."""

import contextlib
import sys
from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from typing import Any, NamedTuple

from mobile_robot_control.configuration.configure import at_cart_start, configure
from mobile_robot_control.configuration.files import Override, Values, load
from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.configuration.robot_files import robot_file
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.reference.cart import Placement
from mobile_robot_control.reference.curve import PATH
from mobile_robot_control.system.texts import printable

File = str | PathLike[str]


class ParameterSources(NamedTuple):
    """
    The sources of a loop's parameters.

    Attributes
    ----------
    robot : str or None
        A robot of this package, or the parameter file of one; read before the files.
    files : tuple of str
        ROS 2 parameter files; later ones win.
    overrides : tuple of (str or (str, object))
        Single parameters, which win over files: ``NODE.PARAMETER:=VALUE``, or name and value.

    """

    robot: str | None = None
    files: tuple[str, ...] = ()
    overrides: tuple[Override, ...] = ()

    def with_files(self, *files: File) -> 'ParameterSources':
        """Return the sources with further files, which win over earlier ones."""
        return self._replace(files=(*self.files, *(fspath(file) for file in files)))

    def with_values(self, values: Mapping[str, object]) -> 'ParameterSources':
        """Return the sources with further values by ``NODE.PARAMETER``, which win."""
        return self._replace(overrides=(*self.overrides, *values.items()))

    @property
    def are_given(self) -> bool:
        """Whether there is any source."""
        return self != ParameterSources()

    def values(self, namespace: str = '/') -> Values:
        """
        Read the values by node; raise ParameterError if a source cannot be read.

        For a cart on a path, the placement of the curve in the robot's file is left out.
        """
        given = load(self.files, self.overrides, namespace)
        if self.robot is None:
            return given
        values = load([robot_file(self.robot), *self.files], self.overrides, namespace)
        cart = values['reference_cart']
        if cart.get('curve') == PATH:
            for name in Placement._fields:
                if name not in given['reference_cart']:
                    cart.pop(name, None)
        return values

    def configuration(self, namespace: str = '/') -> Configuration:
        """
        Make the configuration; without `plant.initial_pose` the robot starts at the cart's start.

        Parameters
        ----------
        namespace : str
            Of the nodes.

        Returns
        -------
        Configuration
            Checked.

        Raises
        ------
        ParameterError
            With every violation.

        """
        values = self.values(namespace)
        # output that a law prints while it prepares its gains must not mix with the results
        with contextlib.redirect_stdout(sys.stderr):
            made = configure(values)
            return made if 'initial_pose' in values['plant'] else at_cart_start(made)


def parameter_sources(
    files: Sequence[File] = (), robot: File | None = None, parameters: Mapping[str, object] | None = None
) -> ParameterSources:
    """Return the sources from the arguments of the Python API; raise ParameterError if values lack names."""
    if parameters is not None and not isinstance(parameters, Mapping):
        raise ParameterError([f'parameters = {printable(repr(parameters))}: write them by NODE.PARAMETER, such as '
                              "{'plant.max_wheel_torque': 3.0}; parameter files come before them, by position"])
    given: dict[str, Any] = dict(parameters or {})
    return ParameterSources(None if robot is None else fspath(robot)).with_files(*files).with_values(given)
