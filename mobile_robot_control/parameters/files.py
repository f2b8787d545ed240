"""Parameter files and command-line overrides, read as ROS 2 reads them."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mobile_robot_control.files import PARAMETER_FILE, read_bounded
from mobile_robot_control.parameters.addressing import addressed_nodes, elsewhere, full_names, is_section, unreached
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.nodes import NODES, parameter_names
from mobile_robot_control.parameters.rcl_yaml import dump_yaml, parse_yaml
from mobile_robot_control.parameters.values import nearest
from mobile_robot_control.texts import shortened

Values = dict[str, dict[str, Any]]


def _flat(tree: Mapping[Any, Any], prefix: str = '') -> Iterator[tuple[str, Any]]:
    """Yield dotted name and value of each leaf of a tree."""
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}', value


def _sections(tree: Mapping[Any, Any], path: str, source: str) -> Iterator[tuple[str, dict[str, Any]]]:
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
    """Return whether any of the four nodes declares a parameter of this dotted name."""
    return any(name in declared for declared in parameter_names().values())


def is_ros_parameter(name: str) -> bool:
    """Return whether a parameter is one that every ROS node has, such as `use_sim_time` or `qos_overrides.*`."""
    return name in ('use_sim_time', 'start_type_description_service') or name.startswith('qos_overrides.')


def _law_hint(name: str, known: Iterable[str]) -> str:
    """Return what to do about a parameter of a group that no node has."""
    group = name.partition('.')[0]
    if group == name or any(one.startswith(f'{group}.') for one in known):
        return ''
    return f"; if '{group}' is a law of your own, name its file with --law"


def _check_names(section: str, values: Mapping[str, Any], nodes: Sequence[str], source: str) -> Iterator[str]:
    """Yield what is wrong with the names of a section that is for some of our nodes."""
    known = set().union(*(parameter_names()[node] for node in nodes))
    for name, value in values.items():
        if name in known or is_ros_parameter(name):
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
            yield f"{source}: unknown parameter '{name}' of '{section}'; {nearest(name, known)}{_law_hint(name, known)}"


def read_parameter_file(path: str | Path) -> list[tuple[str, dict[str, Any]]]:
    """
    Read one ROS 2 parameter file.

    Returns section names and values by dotted name, in the file's order. Raises ParameterError if the file is missing,
    empty, unreadable or not a parameter file.
    """
    source = str(path)
    try:
        text = read_bounded(Path(path), PARAMETER_FILE).decode()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'not a text in UTF-8'
        raise ParameterError([f'{source}: cannot be read ({reason}); name an existing parameter file']) from error
    tree = parse_yaml(text, source)
    if tree is None:
        raise ParameterError([f"{source}: is empty; write '/**: {{ros__parameters: {{...}}}}' or leave the file out"])
    if not isinstance(tree, Mapping):
        raise ParameterError([f'{source}: holds {type(tree).__name__}, not node names with their ros__parameters'])
    return list(_sections(tree, '', source))


def read_override(text: str) -> tuple[str, dict[str, Any]]:
    """
    Read one command-line override ``NODE.PARAMETER:=VALUE``, where NODE may be ``/**`` and the value is YAML.

    Returns the section's name, and the one value by its dotted name. Raises ParameterError if it has another form.

    Examples
    --------
    >>> read_override('plant.duration:=5')
    ('plant', {'duration': 5})

    """
    target, separator, value = text.partition(':=')
    section, dot, name = target.partition('.')
    if not (separator and dot and section and name):
        raise ParameterError([f"-p '{text}': write NODE.PARAMETER:=VALUE, such as plant.duration:=16.0"])
    if section != '/**' and section.strip('/') not in NODES:
        raise ParameterError([f"-p '{text}': there is no node '{section}'; {nearest(section, ['/**', *NODES])}"])
    return section, {name: parse_yaml(value, f"-p '{text}'")}


def merge_sections(
    sources: Iterable[tuple[str, str, Mapping[str, Any]]], names: Mapping[str, str] | None = None
) -> Values:
    """
    Merge sections (source for messages, section name, values) into values by node name; a later one wins.

    The nodes have their full names in the namespace '/', unless others are given. Raises ParameterError naming every
    parameter that no node declares or that stands in a wrong section, every section that misses a node of ours, and
    every source that reaches none; sections for nodes of other packages pass.
    """
    names = full_names() if names is None else names
    values: Values = {node: {} for node in NODES}
    violations: list[str] = []
    reaching: set[str] = set()
    astray: dict[str, str] = {}
    for source, section, given in sources:
        nodes = addressed_nodes(section, names)
        if nodes:
            reaching.add(source)
            violations += _check_names(section, given, nodes, source)
        elif missed := unreached(section, names):
            reaching.add(source)
            violations.append(f'{source}: {missed}')
        elif reason := elsewhere(section, names):
            astray.setdefault(source, f'{source}: {reason}')
        for node in nodes:
            values[node].update({name: value for name, value in given.items() if name in parameter_names()[node]})
    violations += [reason for source, reason in astray.items() if source not in reaching]
    if violations:
        raise ParameterError(violations)
    return values


def load(files: Sequence[str | Path], overrides: Sequence[str] = (), namespace: str = '/') -> Values:
    """
    Read parameter files and overrides into values for each node.

    Parameters
    ----------
    files : sequence of path
        Later ones win.
    overrides : sequence of str
        ``NODE.PARAMETER:=VALUE``; they win over files.
    namespace : str
        In which the nodes run.

    Returns
    -------
    dict of str to dict
        By node name, its values; not yet checked against types and bounds (see `configure`).

    Raises
    ------
    ParameterError
        If a file or an override cannot be read, or names what no node declares.

    """
    sources = [(str(path), section, values) for path in files for section, values in read_parameter_file(path)]
    for text in overrides:
        section, values = read_override(text)
        # a node is named without its namespace there
        sources.append((f"-p '{text}'", section if section == '/**' else f'/**/{section.strip("/")}', values))
    return merge_sections(sources, full_names(namespace))


def parameter_file_text(values: Mapping[str, Mapping[str, Any]]) -> str:
    """
    Return values by node and dotted name as the text of a ROS 2 parameter file.

    One section a node; reading it back gives the same numbers to the last bit.
    """
    tree = {
        f'/**/{node}': {'ros__parameters': {
            name: list(value) if isinstance(value, tuple) else value for name, value in given.items()}}
        for node, given in values.items() if given
    }
    return dump_yaml(tree)
