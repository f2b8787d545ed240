"""The parameters of all four nodes of a run, checked as a whole: from a robot, files, and values; later ones win."""

import contextlib
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from os import PathLike, fspath
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.control.laws import BUILT_IN
from mobile_robot_control.control.velocity_law import PI
from mobile_robot_control.model.plant import VELOCITY
from mobile_robot_control.parameters.declaration import ParameterError, build, declarations, nearest
from mobile_robot_control.reference.cart import Placement
from mobile_robot_control.reference.curves import OF_FILES
from mobile_robot_control.settings.files import Override, Values, load
from mobile_robot_control.settings.nodes import NODES, Configuration, awaits_path, course_of, velocity_loop_is_stable
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.system.texts import printable

_PACKAGE = Path(__file__).resolve().parents[1]
_ENDINGS = ('.yaml', '.yml')


def shipped_folder(name: str, package: Path = _PACKAGE) -> Path | None:
    """Return a folder of config/, in the repository or below the prefix of an installation; None if there is none."""
    places = [package.parent, *(prefix / 'share' / package.name for prefix in package.parents)]
    return next((folder for place in places if (folder := place / 'config' / name).is_dir()), None)


@lru_cache(maxsize=1)
def shipped_robots(package: Path = _PACKAGE) -> dict[str, Path]:
    """
    Return the robots of this package.

    Parameters
    ----------
    package : Path
        The folder of its modules.

    Returns
    -------
    dict of str to Path
        The parameter file by name; empty if the package is installed without its parameter files.

    """
    folder = shipped_folder('robots', package)
    return {file.stem: file for file in sorted(folder.glob('*.yaml'))} if folder else {}


def robot_file(robot: str) -> Path:
    """
    Return the parameter file of a robot.

    Parameters
    ----------
    robot : str
        A name of `shipped_robots`, or the path of a parameter file.

    Returns
    -------
    Path
        Not yet read.

    Raises
    ------
    ParameterError
        If it is neither; with the known names and the nearest.

    """
    shipped = shipped_robots()
    if robot in shipped:
        return shipped[robot]
    # os.path accepts any text
    if os.path.lexists(robot) or '/' in robot or robot.endswith(_ENDINGS):
        return Path(robot)
    if not shipped:
        raise ParameterError([f"--robot '{robot}': the package is installed without its robots; name a parameter file"])
    near = nearest(robot, shipped)
    names = '' if near.startswith('known are') else f'; known are {", ".join(shipped)}'
    raise ParameterError([f"--robot '{robot}': there is no robot of this name; {near}{names}; a file of your own is "
                          'named by its path, such as ./my_robot.yaml'])


def _disagreements(configuration: Configuration) -> Iterator[str]:
    """Yield the shared parameters with different values in the nodes."""
    ours = {node: declarations(type(part.shared), defaults=part.shared) for node, part
            in configuration._asdict().items()}
    for name in declarations(Shared):
        values = {node: shared[name].default for node, shared in ours.items()}
        if len(set(values.values())) > 1:
            told = ', '.join(f'{node} {value}' for node, value in values.items())
            yield f"{name} differs between the nodes ({told}); write it once, under '/**'"


def configure(values: Mapping[str, Mapping[str, object]]) -> Configuration:
    """
    Make the configuration of a run from each node's values, checked as a whole.

    Parameters
    ----------
    values : mapping of str to mapping
        By node name, values by dotted parameter name; omitted nodes keep their defaults.

    Returns
    -------
    Configuration
        The parameters of all four nodes.

    Raises
    ------
    ParameterError
        With every violation once, after the nodes concerned.

    Examples
    --------
    >>> configure({'plant': {'duration': 3}}).plant.duration
    3.0

    """
    unknown = [f"there is no node '{printable(str(node))}'; {nearest(str(node), NODES)}" for node in values
               if node not in NODES]
    if unknown:
        raise ParameterError(unknown)
    parts: dict[str, Any] = {}
    violations: dict[str, list[str]] = {}
    unused = (velocity_loop_is_stable,) if values.get('plant', {}).get('drive') == VELOCITY else ()
    for node, group in NODES.items():
        try:
            parts[node] = build(group, values.get(node, {}), without=unused)
        except ParameterError as error:
            for violation in error.violations:
                violations.setdefault(violation, []).append(node)
    if violations:
        raise ParameterError(f'{", ".join(nodes)}: {violation}' for violation, nodes in violations.items())
    configuration = Configuration(**parts)
    disagreements = (*_disagreements(configuration), *_unlike_drives(configuration))
    if disagreements:
        raise ParameterError(disagreements)
    return configuration


def _unlike_drives(configuration: Configuration) -> Iterator[str]:
    """Yield a velocity law of a base, which has none, and motor parameters of the cart that differ from the plant's."""
    cart, model = configuration.reference_cart, configuration.plant.model
    law = configuration.velocity_controller.control.controller_type
    if model.drive == VELOCITY and law != PI:
        yield (f"velocity_controller.controller_type = '{law}' is of plant.drive = 'torque', and drive is 'velocity': "
               'a base controls its velocity itself; leave it out, or change drive')
    if cart.curve.curve not in OF_FILES or model.drive == VELOCITY:
        return
    for group, ours, theirs in (('motor', cart.motor, model.motor), ('friction', cart.friction, model.friction)):
        for name, value in ours._asdict().items():
            if value != getattr(theirs, name):
                yield (f'{group}.{name} is {value} for reference_cart, which plans a path by it, and '
                       f"{getattr(theirs, name)} for plant; write it under '/**'")


def at_cart_start(configuration: Configuration) -> Configuration:
    """
    Return a configuration with the robot at the start of the reference cart, with the same heading.

    A cart that awaits its path stands at the robot's start.
    """
    if awaits_path(configuration.reference_cart):
        return configuration
    start = course_of(configuration.reference_cart).reference(0.0).pose
    return configuration._replace(plant=configuration.plant._replace(initial_pose=tuple(start)))


@lru_cache(maxsize=8)
def _selected(node: str, laws: tuple[str, ...], default: str) -> dict[str, str]:
    """Return the selection of the only law for a node, and print it, or the choice between several, once."""
    kind = 'velocity law' if node == 'velocity_controller' else 'law'
    if len(laws) == 1:
        print(f"the {kind} '{laws[0]}' of --{kind.replace(' ', '-')} is selected", file=sys.stderr)
        return {'controller_type': laws[0]}
    print(f"the {kind} '{default}' is selected, and none of {', '.join(laws)}; to choose one, add -p "
          f'{node}.controller_type:={laws[-1]}', file=sys.stderr)
    return {}


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
    laws, velocity_laws : tuple of str
        Laws of the user's own; a single one of a kind is selected unless a source names another.

    """

    robot: str | None = None
    files: tuple[str, ...] = ()
    overrides: tuple[Override, ...] = ()
    laws: tuple[str, ...] = ()
    velocity_laws: tuple[str, ...] = ()

    def with_files(self, *files: File) -> 'ParameterSources':
        """Return the sources with further files, which win over earlier ones."""
        return self._replace(files=(*self.files, *(fspath(file) for file in files)))

    def with_values(self, values: Mapping[str, object]) -> 'ParameterSources':
        """Return the sources with further values by ``NODE.PARAMETER``, which win."""
        return self._replace(overrides=(*self.overrides, *values.items()))

    @property
    def are_given(self) -> bool:
        """Whether there is any source."""
        return self._replace(laws=(), velocity_laws=()) != ParameterSources()

    def values(self, namespace: str = '/') -> Values:
        """
        Read the values by node; raise ParameterError if a source cannot be read.

        For a cart on a path or a trajectory, the placement of a curve in earlier sources, as in the file of a search,
        is left out.
        """
        files = [*(() if self.robot is None else [robot_file(self.robot)]), *self.files]
        values = load(files, self.overrides, namespace)
        cart = values['reference_cart']
        if cart.get('curve') not in OF_FILES:
            return values
        # from the last source on that names it
        for first in range(len(files), -1, -1):
            with contextlib.suppress(ParameterError):
                kept = load(files[first:], self.overrides, namespace)['reference_cart']
                if kept.get('curve') == cart['curve']:
                    values['reference_cart'] = {name: value for name, value in cart.items()
                                                if name in kept or name not in Placement._fields}
                    break
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
        for node, laws, default in (('position_controller', self.laws, BUILT_IN[0].name),
                                    ('velocity_controller', self.velocity_laws, PI)):
            if laws and 'controller_type' not in values[node]:
                values[node] |= _selected(node, laws, default)
        # output that a law prints while it prepares its gains must not mix with the results
        with contextlib.redirect_stdout(sys.stderr):
            configuration = configure(values)
            return configuration if 'initial_pose' in values['plant'] else at_cart_start(configuration)


def parameter_sources(
    files: Sequence[File] = (), robot: File | None = None, parameters: Mapping[str, object] | None = None
) -> ParameterSources:
    """Return the sources from the arguments of the Python API; raise ParameterError if values lack names."""
    if parameters is not None and not isinstance(parameters, Mapping):
        raise ParameterError([f'parameters = {printable(repr(parameters))}: write them by NODE.PARAMETER, such as '
                              "{'plant.max_wheel_torque': 3.0}; parameter files come before them, by position"])
    values: dict[str, Any] = dict(parameters or {})
    return ParameterSources(None if robot is None else fspath(robot)).with_files(*files).with_values(values)
