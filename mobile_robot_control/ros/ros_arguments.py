"""ROS arguments, read before rcl reads them: what rcl would ignore in silence is refused."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.files import addressed_nodes, merge_sections, read_parameter_file
from mobile_robot_control.parameters.rcl_yaml import parse_yaml


class _Source(NamedTuple):
    where: str  # for messages
    section: str
    values: Mapping[str, Any]
    rule: str = ''  # a `-p` that a node's name may be put before


def check_ros_arguments(names: Sequence[str], arguments: Sequence[str]) -> None:
    """
    Check the parameters that nodes are about to be started with.

    Raises ParameterError naming what rcl ignores in silence: empty files, unknown names, names in a wrong section, and
    values that are written last but lose.
    """
    namespace = _namespace(arguments)
    sources = list(_sources(arguments, namespace))
    merge_sections(((source.where, source.section, source.values) for source in sources), namespace)
    violations = [violation for name in names for violation in _losing(sources, name, namespace)]
    if violations:
        raise ParameterError(violations)


def _namespace(arguments: Sequence[str]) -> str:
    """Return the namespace that the nodes are remapped to."""
    rules = [argument.partition('__ns:=')[2] for argument in arguments if '__ns:=' in argument]
    return rules[-1] if rules else '/'


def _sources(arguments: Sequence[str], namespace: str) -> Iterator[_Source]:
    """Yield every section of files and every `-p`, in their order."""
    for option, value in itertools.pairwise(arguments):
        if option == '--params-file':
            for section, values in read_parameter_file(value):
                yield _Source(value, section, values)
        elif option in ('-p', '--param') and ':=' in value:
            yield _rule(value, namespace)


def _rule(text: str, namespace: str) -> _Source:
    """Read one `-p`."""
    target, _, value = text.partition(':=')
    node, _, name = target.rpartition(':')
    where = f"-p '{text}'"
    if node and not addressed_nodes(node, namespace) and addressed_nodes(f'/**/{node}', namespace):
        raise ParameterError([f"{where}: reaches no node in the namespace '{namespace}'; "
                              f"write '{name}: {value}' under '/**/{node}' of a file"])
    return _Source(where, node or '/**', {name: parse_yaml(value, where)}, '' if node or namespace != '/' else text)


def _losing(sources: Sequence[_Source], node: str, namespace: str) -> Iterator[str]:
    """
    Yield the values that are written last for a node but lose.

    rcl gives a section the position at which its name was first written, `-p` without a node being the section '/**'.
    Of two sections for a node the one with the later position wins, whatever was written last.
    """
    places: dict[str, int] = {}
    last: dict[str, _Source] = {}
    winning: dict[str, _Source] = {}
    for source in sources:
        place = places.setdefault(source.section, len(places))
        for name in source.values if node in addressed_nodes(source.section, namespace) else ():
            last[name] = source
            if place >= places[winning.get(name, source).section]:
                winning[name] = source
    for name, source in last.items():
        winner = winning[name]
        if winner is not source and winner.values[name] != source.values[name]:
            remedy = f'-p {node}:{source.rule}' if source.rule else f"it under '{winner.section}' of a file"
            yield (f'{source.where}: {name} = {source.values[name]!r} would lose in ROS 2 against '
                   f"{winner.values[name]!r} under '{winner.section}' ({winner.where}); write {remedy}")
