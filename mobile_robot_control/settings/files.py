"""Parameter files and command-line overrides, read as ROS 2 reads them and addressed by the nodes' full names."""

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mobile_robot_control.parameters.declaration import ParameterError, flatten, nearest
from mobile_robot_control.parameters.rcl_yaml import dump_yaml, parse_yaml
from mobile_robot_control.reference.curves import PATH, TRAJECTORY
from mobile_robot_control.reference.path_parameters import NO_FILE
from mobile_robot_control.reference.trajectory_files import table_of_trajectory
from mobile_robot_control.reference.waypoint_files import WAYPOINTS, YAML_SUFFIXES
from mobile_robot_control.reference.waypoints import table_of
from mobile_robot_control.settings.nodes import NODES, Configuration, parameter_names
from mobile_robot_control.settings.recorded_path import is_bag, trajectory_in, waypoints_in
from mobile_robot_control.system.files import PARAMETER_FILE, read_bounded, write_atomically
from mobile_robot_control.system.texts import printable, shortened

_SECTION = re.compile(r'/?(\*\*?|[A-Za-z_]\w*)(/(\*\*?|[A-Za-z_]\w*))*', re.ASCII)
_LONGEST_NAMESPACE = 200  # so that a node's longest service name stays within the 247 characters that rmw allows


def full_names(namespace: str = '/', renamed: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the full name of each of the four nodes in a namespace, some of them renamed."""
    return {node: f'{namespace.rstrip("/")}/{(renamed or {}).get(node, node)}' for node in NODES}


def is_section(text: str) -> bool:
    """Return whether rcl accepts a text as the name of a section: tokens, '*' and '**' between single slashes."""
    return _SECTION.fullmatch(text) is not None


def addressed_nodes(section: str, names: Mapping[str, str]) -> list[str]:
    """Return those of the four nodes that a section reaches, by rcl's wildcards: '*' is one token, '**' any number."""
    return [node for node, name in names.items() if _reaches(section, name)]


def _reaches(section: str, name: str) -> bool:
    """Return whether a section reaches the node of a full name."""
    pattern = re.escape('/' + section.strip('/')).replace(r'/\*\*', '(/[^/]+)*').replace(r'\*', '[^/]+')
    return re.fullmatch(pattern, name) is not None


def namespace_of(name: str) -> str:
    """Return the namespace of a full name."""
    return name.rpartition('/')[0] or '/'


def unreached(section: str, names: Mapping[str, str]) -> str:
    """Explain why a section meant for one of the four nodes reaches none, with the remedy; '' if it was not."""
    for node, name in names.items():
        namespace, _, present = name.rpartition('/')
        if section.strip('/') != node and not _reaches(section, f'{namespace}/{node}'):
            continue
        if present != node:
            return (f"section '{section}' does not reach the node {node}, which is renamed '{present}'; "
                    f"write '/**/{present}'")
        return f"section '{section}' is for a node outside the namespace '{namespace}'; write '/**/{node}'"
    return ''


def misspelt(section: str, values: Mapping[str, object]) -> str:
    """Explain which of the four nodes a section means whose name none has, with the remedy; '' if it means none."""
    import difflib  # noqa: PLC0415 (a node starts sooner without)

    name = section.rpartition('/')[2]
    near = difflib.get_close_matches(name, NODES, n=1, cutoff=0.8)
    # a name that contains a node's, such as plant_2, is one of a renamed node elsewhere
    if not near or near[0] in name or not set(values) <= set(parameter_names()[near[0]]):
        return ''
    return f"there is no node '{printable(name)}'; did you mean '{near[0]}'?"


def elsewhere(section: str, names: Mapping[str, str]) -> str:
    """Explain why a section is for one of the four nodes in another namespace, with the remedy; '' if it is not."""
    node = section.rpartition('/')[2]
    if node not in names:
        return ''
    return (f"reaches no node in the namespace '{namespace_of(names[node])}': section '{section}' is for another one; "
            f"write '/**/{names[node].rpartition('/')[2]}'")


def namespace_fault(namespace: str) -> str:
    """Describe the fault in a namespace, with the remedy; '' if ROS accepts it."""
    if _is_namespace(namespace):
        return ''
    near = '/' + '/'.join(filter(None, namespace.split('/')))
    return (f"'{namespace}' is no namespace of ROS (letters, digits and single '_' between single '/', at most "
            f"{_LONGEST_NAMESPACE} characters); write one such as "
            f"'{near if near != '/' and _is_namespace(near) else '/robot1'}'")


def _is_namespace(text: str) -> bool:
    return (re.fullmatch(r'/|(/[A-Za-z_][A-Za-z0-9_]*)+', text) is not None and '__' not in text
            and len(text) <= _LONGEST_NAMESPACE)


def read_namespace(value: str) -> str:
    """Return a namespace; raise ValueError if ROS does not accept it."""
    fault = namespace_fault(value)
    if fault:
        raise ValueError(fault)
    return value


Values = dict[str, dict[str, Any]]
PATH_FILE, TRAJECTORY_FILE = 'path.file', 'trajectory.file'
FILES = (PATH_FILE, TRAJECTORY_FILE)
TRACK = 'track'
"""The section of a benchmark's track, whose file may name no node."""
Override = str | tuple[str, Any]
"""One parameter: ``NODE.PARAMETER:=VALUE`` with a value in YAML, or name and value."""


def _flat(tree: Mapping[Any, object], prefix: str = '') -> Iterator[tuple[str, Any]]:
    """Yield dotted name and value of each leaf of a tree."""
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}', value


def _sections(tree: Mapping[Any, object], path: str, source: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield node name (with its namespace, if written) and values of each section, in the file's order."""
    for key, value in tree.items():
        name = f'{path}/{str(key).strip("/")}' if path else str(key)
        if key == 'ros__parameters':
            if not path:
                raise ParameterError([f"{source}: 'ros__parameters' stands outside a node; "
                                      "write '/**: {ros__parameters: {...}}'"])
            if not isinstance(value, Mapping) or not value:
                raise ParameterError([f"{source}: 'ros__parameters' of '{path}' is empty; "
                                      "write 'name: value' under it"])
            if not is_section(path):
                raise ParameterError([f"{source}: '{shortened(path, 60)}' is no name of a node, and nodes refuse the "
                                      "file; write one such as 'plant', '/robot1/plant' or '/**'"])
            yield path, dict(_flat(value))
        elif isinstance(value, Mapping):
            yield from _sections(value, name, source)
        else:
            raise ParameterError([f"{source}: '{name}' stands outside a node's 'ros__parameters'; "
                                  f"write '/**: {{ros__parameters: {{{key}: ...}}}}'"])


def is_declared(name: str) -> bool:
    """Return whether any of the four nodes declares a parameter with this dotted name."""
    return any(name in declared for declared in parameter_names().values())


def is_ros_parameter(name: str) -> bool:
    """Return whether every ROS node has a parameter, such as `use_sim_time` or `qos_overrides.*`."""
    return name in ('use_sim_time', 'start_type_description_service') or name.startswith('qos_overrides.')


def _law_hint(name: str, declared: Iterable[str]) -> str:
    """Return the remedy for a parameter of an unknown group."""
    group = name.partition('.')[0]
    if group == name or any(one.startswith(f'{group}.') for one in declared):
        return ''
    return f"; if '{group}' is a law of your own, name its file with --law, or register it in Python"


def _check_names(section: str, values: Mapping[str, object], nodes: Sequence[str], source: str) -> Iterator[str]:
    """Yield the faults in the names of a section for some of the four nodes."""
    names = set().union(*(parameter_names()[node] for node in nodes))
    for name, value in values.items():
        if name in names or is_ros_parameter(name):
            if value is None:
                yield f"{source}: '{name}' of '{section}' has no value; write one, or leave the line out"
            elif isinstance(value, list) and len({type(element) for element in value}) > 1:
                yield (f"{source}: '{name}' of '{section}' = {value} mixes kinds of numbers, which ROS refuses; "
                       f'write a decimal point in each: {[float(v) if type(v) is int else v for v in value]}')
            continue
        owners = [node for node, declared in parameter_names().items() if name in declared]
        if owners:
            yield f"{source}: '{name}' of '{section}' belongs to {' and '.join(owners)}; write it there"
        else:
            yield f"{source}: unknown parameter '{name}' of '{section}'; {nearest(name, names)}{_law_hint(name, names)}"


def read_parameter_file(path: str | Path) -> list[tuple[str, dict[str, Any]]]:
    """
    Read one ROS 2 parameter file.

    Returns section names and values by dotted name, in the file's order. Raises ParameterError if the file is missing,
    empty, unreadable or not a parameter file.
    """
    source = str(path)
    try:
        content = read_bounded(Path(path), PARAMETER_FILE).decode()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'not a text in UTF-8'
        raise ParameterError([f'{source}: cannot be read ({reason}); name an existing parameter file']) from error
    tree = parse_yaml(content, source)
    if tree is None:
        raise ParameterError([f"{source}: is empty; write '/**: {{ros__parameters: {{...}}}}' or leave the file out"])
    if not isinstance(tree, Mapping):
        raise ParameterError([f'{source}: holds {type(tree).__name__}, not node names with their ros__parameters'])
    return list(_sections(tree, '', source))


def _plain(value: object) -> Any:
    """Convert a Python value to the types of YAML: without NumPy, and with one kind of number in an array."""
    value = value.tolist() if hasattr(value, 'tolist') else value
    if not isinstance(value, list | tuple):
        return value
    numbers = [_plain(element) for element in value]
    return [float(number) if type(number) is int and any(isinstance(one, float) for one in numbers) else number
            for number in numbers]


def read_override(override: Override) -> tuple[str, str, dict[str, Any]]:
    """
    Read one parameter; its NODE may be ``/**``.

    Returns its source for messages, the section's name, and the one value by its dotted name. Raises ParameterError for
    any other form.

    Examples
    --------
    >>> read_override('plant.duration:=5')
    ("-p 'plant.duration:=5'", 'plant', {'duration': 5})
    >>> read_override(('plant.duration', 5.0))[1:]
    ('plant', {'duration': 5.0})

    """
    if isinstance(override, str):
        target, separator, written = override.partition(':=')
        source = f"-p '{override}'"
    else:
        target, separator, value = str(override[0]), ':=', _plain(override[1])
        source = f"-p '{target}:={value!r}'"
    section, dot, name = target.partition('.')
    if not (separator and dot and section and name):
        raise ParameterError([f'{source}: write NODE.PARAMETER:=VALUE, such as plant.duration:=16.0'])
    if section != '/**' and section.strip('/') not in NODES:
        raise ParameterError([f"{source}: there is no node '{section}'; {nearest(section, ['/**', *NODES])}"])
    return source, section, {name: parse_yaml(written, source) if isinstance(override, str) else value}


def merge_sections(
    sources: Iterable[tuple[str, str, Mapping[str, object]]], names: Mapping[str, str] | None = None
) -> Values:
    """
    Merge sections (source for messages, section name, values) into values by node name; later ones win.

    By default the nodes have their full names in the namespace '/'. Raises ParameterError with every parameter that no
    node declares or that stands in a wrong section, every section that misses one of the four nodes, and every source
    that reaches none; sections for nodes of other packages pass.
    """
    names = full_names() if names is None else names
    values: Values = {node: {} for node in NODES}
    violations: list[str] = []
    reaching: set[str] = set()
    astray: dict[str, str] = {}
    for source, section, parameters in sources:
        nodes = addressed_nodes(section, names)
        if nodes:
            reaching.add(source)
            violations += _check_names(section, parameters, nodes, source)
        elif missed := unreached(section, names):
            reaching.add(source)
            violations.append(f'{source}: {missed}')
        elif fault := misspelt(section, parameters):
            reaching.add(source)
            violations.append(f'{source}: {fault}')
        elif reason := elsewhere(section, names):
            astray.setdefault(source, f'{source}: {reason}')
        for node in nodes:
            values[node].update({name: value for name, value in parameters.items() if name in parameter_names()[node]})
    violations += [reason for source, reason in astray.items() if source not in reaching]
    if violations:
        raise ParameterError(violations)
    return values


def files_of_others(sections: Iterable[tuple[str, str]], names: Mapping[str, str]) -> list[str]:
    """Describe the files of which no section is for one of the four nodes, from pairs of a file and its section."""
    sections_by_file: dict[str, list[str]] = {}
    ours: set[str] = set()
    for file, section in sections:
        sections_by_file.setdefault(file, []).append(section)
        if (addressed_nodes(section, names) or unreached(section, names) or elsewhere(section, names)
                or misspelt(section, {})
                or section.strip('/') == TRACK):
            ours.add(file)
    return [f"{file}: no section names a node of this package, only {shortened(', '.join(others), 60)}; write "
            f"'/**' or one of {', '.join(names)}, or leave the file out"
            for file, others in sections_by_file.items() if file not in ours]


def located(values: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return values with an absolute path of the points, relative to the folder of the file that names them."""
    named = {name: values[name] for name in FILES if isinstance(values.get(name), str)}
    return {**values, **{name: os.path.abspath(folder / file) for name, file in named.items()
                         if file not in ('', NO_FILE)}}


def load(files: Sequence[str | Path], overrides: Sequence[Override] = (), namespace: str = '/') -> Values:
    """
    Read parameter files and overrides into values for each node.

    Parameters
    ----------
    files : sequence of path
        Later ones win.
    overrides : sequence of (str or (str, object))
        ``NODE.PARAMETER:=VALUE``, or name and value; they win over files.
    namespace : str
        Of the nodes.

    Returns
    -------
    dict of str to dict
        By node name, its values; not yet checked against types and bounds (see `configure`).

    Raises
    ------
    ParameterError
        If a file or an override cannot be read, names a parameter that no node declares, or is for other nodes alone.

    """
    sources = [(str(path), section, located(values, Path(path).parent))
               for path in files for section, values in read_parameter_file(path)]
    names = full_names(namespace)
    if foreign := files_of_others(((file, section) for file, section, _ in sources), names):
        raise ParameterError(foreign)
    for override in overrides:
        source, section, values = read_override(override)
        values = located(values, Path())
        # an override names a node without its namespace
        sources.append((source, section if section == '/**' else f'/**/{section.strip("/")}', values))
    return merge_sections(sources, names)


def parameter_file_text(values: Mapping[str, Mapping[str, object]]) -> str:
    """
    Return values by node and dotted name as the text of a ROS 2 parameter file.

    One section a node; its numbers read back the same to the last bit.
    """
    tree = {
        f'/**/{node}': {'ros__parameters': {
            name: list(value) if isinstance(value, tuple) else value for name, value in parameters.items()}}
        for node, parameters in values.items() if parameters
    }
    return dump_yaml(tree)


def configuration_text(parameters: Configuration, robot: str | None = None) -> str:
    """Return a configuration as a parameter file with the same numbers to the last bit, headed by its robot."""
    text = parameter_file_text({node: flatten(part) for node, part in parameters._asdict().items()})
    return text if robot is None else f'# robot: {printable(robot)}\n{text}'


def save_configuration(file: Path, parameters: Configuration, robot: str | None = None) -> None:
    """Write a configuration as a parameter file, and a copy of the points that it names beside it."""
    cart = parameters.reference_cart
    if cart.curve.curve == PATH and cart.path.file != NO_FILE:
        source = Path(cart.path.file)
        suffix = source.suffix if source.suffix in YAML_SUFFIXES else '.csv'
        copy = file.with_name(f'{file.stem}.waypoints{suffix}')
        write_atomically(copy, table_of(waypoints_in(cart.path)) if is_bag(source)
                         else read_bounded(source, WAYPOINTS))
        parameters = parameters._replace(reference_cart=cart._replace(
            path=cart.path._replace(file=copy.name, topic=NO_FILE)))
    elif cart.curve.curve == TRAJECTORY:
        source = Path(cart.trajectory.file)
        copy = file.with_name(f'{file.stem}.trajectory{".csv" if is_bag(source) else source.suffix}')
        write_atomically(copy, table_of_trajectory(trajectory_in(cart.trajectory)) if is_bag(source)
                         else read_bounded(source, WAYPOINTS))
        parameters = parameters._replace(reference_cart=cart._replace(
            trajectory=cart.trajectory._replace(file=copy.name, topic=NO_FILE)))
    write_atomically(file, configuration_text(parameters, robot))
