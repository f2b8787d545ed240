"""Parameter files and command-line overrides, read as ROS 2 reads them."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mobile_robot_control.configuration import NODES
from mobile_robot_control.fields import nearest
from mobile_robot_control.parameters import ParameterError, declarations
from mobile_robot_control.rcl_yaml import dump, parse

_DECLARED = {node: set(declarations(group)) for node, group in NODES.items()}
Values = dict[str, dict[str, Any]]


def _flat(tree: Mapping[Any, Any], prefix: str = '') -> Iterator[tuple[str, Any]]:
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
            yield path, dict(_flat(value))
        elif isinstance(value, Mapping):
            yield from _sections(value, name, source)
        else:
            raise ParameterError([f"{source}: '{name}' stands outside a node's 'ros__parameters'; "
                                  f"write '/**: {{ros__parameters: {{{key}: ...}}}}'"])


def addressed(section: str, namespace: str) -> list[str]:
    """
    Give the nodes that a section is for, by rcl's wildcards: '*' is one token, '**' any number of them.

    Parameters
    ----------
    section : str
        Its name.
    namespace : str
        In which the nodes run.

    Returns
    -------
    list of str
        Those of the four nodes that take its values.

    """
    pattern = re.escape('/' + section.strip('/'))
    expression = pattern.replace(r'/\*\*', '(/[^/]+)*').replace(r'\*', '[^/]+')
    return [node for node in NODES if re.fullmatch(expression, f'{namespace.rstrip("/")}/{node}')]


def is_declared(name: str) -> bool:
    """
    Say whether any of the four nodes declares a parameter.

    Parameters
    ----------
    name : str
        Dotted name.

    Returns
    -------
    bool
        True if one does.

    """
    return any(name in declared for declared in _DECLARED.values())


def not_ours(name: str) -> bool:
    """
    Say whether a parameter is one of those that every ROS node has.

    Parameters
    ----------
    name : str
        Dotted name.

    Returns
    -------
    bool
        True for `use_sim_time`, `qos_overrides.*` and the like.

    """
    return name in ('use_sim_time', 'start_type_description_service') or name.startswith('qos_overrides.')


def _check_names(section: str, values: Mapping[str, Any], nodes: Sequence[str], source: str) -> Iterator[str]:
    """Yield what is wrong with the names of a section that is for some of our nodes."""
    known = set().union(*(_DECLARED[node] for node in nodes))
    for name, value in values.items():
        if name in known or not_ours(name):
            if value is None:
                yield f"{source}: '{name}' of '{section}' has no value; write one, or leave the line out"
            elif isinstance(value, list) and len({type(element) for element in value}) > 1:
                yield (f"{source}: '{name}' of '{section}' = {value} mixes kinds of numbers, which ROS refuses; "
                       f'write a decimal point in each: {[float(v) if type(v) is int else v for v in value]}')
            continue
        owners = [node for node, declared in _DECLARED.items() if name in declared]
        if owners:
            yield f"{source}: '{name}' of '{section}' belongs to {' and '.join(owners)}; write it there"
        else:
            yield f"{source}: unknown parameter '{name}' of '{section}'; {nearest(name, known)}"


def read(path: str | Path) -> list[tuple[str, dict[str, Any]]]:
    """
    Read one ROS 2 parameter file.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    list of (str, dict)
        Section name and values by dotted name, in the file's order.

    Raises
    ------
    ParameterError
        If the file is missing, empty, unreadable or not a parameter file.

    """
    source = str(path)
    try:
        text = Path(path).read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'not a text in UTF-8'
        raise ParameterError([f'{source}: cannot be read ({reason}); name an existing parameter file']) from error
    tree = parse(text, source)
    if tree is None:
        raise ParameterError([f"{source}: is empty; write '/**: {{ros__parameters: {{...}}}}' or leave the file out"])
    if not isinstance(tree, Mapping):
        raise ParameterError([f'{source}: holds {type(tree).__name__}, not node names with their ros__parameters'])
    return list(_sections(tree, '', source))


def override(text: str) -> tuple[str, dict[str, Any]]:
    """
    Read one command-line override.

    Parameters
    ----------
    text : str
        ``NODE.PARAMETER:=VALUE``, where NODE may be ``/**``; the value is YAML.

    Returns
    -------
    tuple of str and dict
        Section name, and the one value by its dotted name.

    Raises
    ------
    ParameterError
        If it has another form.

    Examples
    --------
    >>> override('plant.duration:=5')
    ('plant', {'duration': 5})

    """
    target, separator, value = text.partition(':=')
    section, dot, name = target.partition('.')
    if not (separator and dot and section and name):
        raise ParameterError([f"-p '{text}': write NODE.PARAMETER:=VALUE, such as plant.duration:=16.0"])
    if section != '/**' and section.strip('/') not in NODES:
        raise ParameterError([f"-p '{text}': there is no node '{section}'; {nearest(section, ['/**', *NODES])}"])
    return section, {name: parse(value, f"-p '{text}'")}


def merge(sources: Iterable[tuple[str, str, Mapping[str, Any]]], namespace: str = '/') -> Values:
    """
    Merge sections into values for each node; a later one wins.

    Parameters
    ----------
    sources : iterable of (str, str, mapping)
        Where it was written (for messages), section name, values by dotted name.
    namespace : str
        In which the nodes run.

    Returns
    -------
    dict of str to dict
        By node name, its values.

    Raises
    ------
    ParameterError
        Naming every parameter that no node declares, or that stands in a wrong section; sections of other people's
        nodes pass.

    """
    values: Values = {node: {} for node in NODES}
    violations: list[str] = []
    for source, section, given in sources:
        nodes = addressed(section, namespace)
        if not nodes:
            if section.strip('/') in NODES:
                violations.append(f"{source}: section '{section}' is for a node outside the namespace '{namespace}'; "
                                  f"write '/**/{section.strip('/')}'")
            continue
        violations += _check_names(section, given, nodes, source)
        for node in nodes:
            values[node].update({name: value for name, value in given.items() if name in _DECLARED[node]})
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
        By node name, its values; not yet checked against types and bounds.

    Raises
    ------
    ParameterError
        As :func:`read`, :func:`override` and :func:`merge`.

    """
    sources = [(str(path), section, values) for path in files for section, values in read(path)]
    for text in overrides:
        section, values = override(text)
        # a node is named without its namespace there
        sources.append((f"-p '{text}'", section if section == '/**' else f'/**/{section.strip("/")}', values))
    return merge(sources, namespace)


def write(values: Mapping[str, Mapping[str, Any]]) -> str:
    """
    Give values by node as the text of a ROS 2 parameter file.

    Parameters
    ----------
    values : mapping of str to mapping
        By node name, values by dotted name.

    Returns
    -------
    str
        YAML with one section a node; reading it back gives the same numbers to the last bit.

    """
    tree = {
        f'/**/{node}': {'ros__parameters': {
            name: list(value) if isinstance(value, tuple) else value for name, value in given.items()}}
        for node, given in values.items() if given
    }
    return dump(tree)
