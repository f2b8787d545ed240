"""The ROS arguments of nodes: those that rcl would silently ignore are refused."""

import itertools
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.parameters.rcl_yaml import parse_yaml
from mobile_robot_control.reference.cart import Placement
from mobile_robot_control.reference.curves import OF_FILES
from mobile_robot_control.settings.files import (
    FILES,
    addressed_nodes,
    files_of_others,
    full_names,
    located,
    merge_sections,
    namespace_fault,
    namespace_of,
    read_parameter_file,
)
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.system.texts import printable

_Options = Sequence[tuple[str, str]]


class _Source(NamedTuple):
    where: str  # for messages
    section: str
    values: Mapping[str, Any]
    rule: str = ''  # a `-p` that a node's name may be put before
    is_of_file: bool = False


def check_ros_arguments(names: Sequence[str], arguments: Sequence[str]) -> dict[str, Any]:
    """
    Check the arguments of nodes before their start.

    Returns the values of the reference cart that replace those that rcl reads: the file of waypoints, relative to the
    folder of the file that names it, and for a path the defaults of what places a curve in an earlier file.

    Raises ParameterError for all that rcl ignores silently: arguments outside `--ros-args`, empty files, unknown names,
    names in a wrong section, sections that do not reach a renamed node, and values that are written last but lose; and
    for all that ROS refuses: a namespace or names, and texts that are not UTF-8.
    """
    odd = [argument for argument in arguments if any('\ud800' <= letter <= '\udfff' for letter in argument)]
    if odd:
        raise ParameterError(f"'{printable(argument)}' is not UTF-8, the only encoding of ROS; write it otherwise"
                             for argument in odd)
    options = _options(arguments)
    full = _full_names(names, options)
    sources = list(_sources(options, full))
    # nodes of several packages may share one launch file and its parameters
    for foreign in files_of_others(((one.where, one.section) for one in sources if one.is_of_file), full):
        print(f'{" ".join(names)}: {printable(foreign)}', file=sys.stderr)
    values = merge_sections(((source.where, source.section, source.values) for source in sources), full)
    violations = [violation for name in names for violation in _losing(sources, name, full)]
    if violations:
        raise ParameterError(violations)
    cart = values['reference_cart']
    return {name: cart[name] for name in FILES if name in cart} | _unplaced(sources, full)


def _options(arguments: Sequence[str]) -> _Options:
    """Return each argument within `--ros-args` with the next one; raise ParameterError for those outside."""
    within, inside, outside = False, [], []
    for argument, following in itertools.zip_longest(arguments, arguments[1:], fillvalue=''):
        if argument == '--ros-args':
            within = True
        elif argument == '--' and within:
            within = False
        elif within:
            inside.append((argument, following))
        else:
            outside.append(f"'{argument}' has no effect: nodes take ROS arguments alone; write --ros-args before them")
    if outside:
        raise ParameterError(outside)
    return inside


def _remapped(options: _Options, targets: Iterable[str], node: str) -> str | None:
    """Return a node's new name by the first matching rule for a target such as '__ns'; None without a rule."""
    for option, rule in options:
        target, separator, value = rule.partition(':=')
        if option in ('-r', '--remap') and separator and target in {*targets, *(f'{node}:{name}' for name in targets)}:
            return value
    return None


def _full_names(names: Sequence[str], options: _Options) -> dict[str, str]:
    """Return the full name of each of the four nodes; those of this process may be renamed."""
    full = {}
    for node in NODES:
        # rcl applies a rule without a node's name to every node of the process, and renames before it moves
        name = (_remapped(options, ('__node', '__name'), node) if node in names else None) or node
        namespace = _remapped(options, ('__ns',), name)
        fault = '' if namespace is None else namespace_fault(namespace)
        if fault:
            raise ParameterError([f"-r '__ns:={namespace}': {fault}"])
        full[node] = full_names(namespace or '/', {node: name})[node]
    own = [full[node] for node in names]
    if len(set(own)) < len(own):
        raise ParameterError([f"{', '.join(names)} would have the names {', '.join(own)}; rename one of them alone, "
                              f"such as -r {names[0]}:__node:=my_{names[0]}"])
    return full


def _sources(options: _Options, full: Mapping[str, str]) -> Iterator[_Source]:
    """Yield every section of files and every `-p`, in their order."""
    for option, value in options:
        if option == '--params-file':
            for section, values in read_parameter_file(value):
                yield _Source(value, section, located(values, Path(value).parent), is_of_file=True)
        elif option in ('-p', '--param') and ':=' in value:
            yield _rule(value, full)


def _rule(override: str, full: Mapping[str, str]) -> _Source:
    """Read one `-p`."""
    target, _, value = override.partition(':=')
    node, _, name = target.rpartition(':')
    where = f"-p '{override}'"
    present = full.get(node, f'/{node}').rpartition('/')[2]
    if node and not addressed_nodes(node, full) and addressed_nodes(f'/**/{present}', full):
        if node != present and addressed_nodes(present, full):
            raise ParameterError([f"{where}: reaches no node, since {node} is renamed '{present}'; "
                                  f"write -p '{present}:{name}:={value}'"])
        namespace = next(namespace_of(full[found]) for found in addressed_nodes(f'/**/{present}', full))
        raise ParameterError([f"{where}: reaches no node in the namespace '{namespace}'; "
                              f"write '{name}: {value}' under '/**/{present}' of a file"])
    in_root = {namespace_of(each) for each in full.values()} == {'/'}
    return _Source(where, node or '/**', {name: parse_yaml(value, where)}, '' if node or not in_root else override)


def _losing(sources: Sequence[_Source], node: str, full: Mapping[str, str]) -> Iterator[str]:
    """Yield the values that are written last for a node but lose."""
    # rcl gives a section the position of its first occurrence; `-p` without a node is the section '/**'. Of two
    # sections for a node the one with the later position wins, whatever was written last
    places: dict[str, int] = {}
    last: dict[str, _Source] = {}
    winning: dict[str, _Source] = {}
    for source in sources:
        place = places.setdefault(source.section, len(places))
        for name in source.values if node in addressed_nodes(source.section, full) else ():
            last[name] = source
            if place >= places[winning.get(name, source).section]:
                winning[name] = source
    for name, source in last.items():
        winner = winning[name]
        if winner is not source and winner.values[name] != source.values[name]:
            remedy = (f"-p {full[node].rpartition('/')[2]}:{source.rule}" if source.rule
                      else f"it under '{winner.section}' of a file")
            yield (f'{source.where}: {name} = {source.values[name]!r} would lose in ROS 2 against '
                   f"{winner.values[name]!r} under '{winner.section}' ({winner.where}); write {remedy}")


def _unplaced(sources: Sequence[_Source], full: Mapping[str, str]) -> dict[str, Any]:
    """Return the defaults of what places a curve in files before the last one that names the path of the cart."""
    ours = [one for one in sources if 'reference_cart' in addressed_nodes(one.section, full)]
    *_, naming = [one for one in ours if 'curve' in one.values] or [_Source('', '', {})]
    if naming.values.get('curve') not in OF_FILES:
        return {}
    first = next(n for n, one in enumerate(ours) if one.where == naming.where)
    kept = {name for n, one in enumerate(ours) if n >= first or not one.is_of_file for name in one.values}
    return {name: default for name, default in Placement()._asdict().items() if name not in kept}
