"""ROS arguments, read before rcl reads them: what rcl would lose in silence is refused."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.parameter_files import addressed, merge, read
from mobile_robot_control.parameters import ParameterError
from mobile_robot_control.rcl_yaml import parse


class _Source(NamedTuple):
    where: str  # for messages
    section: str
    values: Mapping[str, Any]
    rule: str = ''  # what a node's name may be written before


def check(names: Sequence[str], arguments: Sequence[str]) -> None:
    """
    Check the parameters that nodes are about to be started with.

    Parameters
    ----------
    names : sequence of str
        The nodes.
    arguments : sequence of str
        ROS arguments.

    Raises
    ------
    ParameterError
        Naming what rcl passes over without a word: empty files, unknown names, names in a wrong section, and values
        that stand last but lose.

    """
    namespace = _namespace(arguments)
    sources = list(_sources(arguments, namespace))
    merge(((source.where, source.section, source.values) for source in sources), namespace)
    violations = [violation for name in names for violation in _losing(sources, name, namespace)]
    if violations:
        raise ParameterError(violations)


def _namespace(arguments: Sequence[str]) -> str:
    rules = [argument.partition('__ns:=')[2] for argument in arguments if '__ns:=' in argument]
    return rules[-1] if rules else '/'


def _sources(arguments: Sequence[str], namespace: str) -> Iterator[_Source]:
    for option, value in itertools.pairwise(arguments):
        if option == '--params-file':
            for section, values in read(value):
                yield _Source(value, section, values)
        elif option in ('-p', '--param') and ':=' in value:
            yield _rule(value, namespace)


def _rule(text: str, namespace: str) -> _Source:
    target, _, value = text.partition(':=')
    node, _, name = target.rpartition(':')
    where = f"-p '{text}'"
    if node and not addressed(node, namespace) and addressed(f'/**/{node}', namespace):
        raise ParameterError([f"{where}: reaches no node in the namespace '{namespace}'; "
                              f"write '{name}: {value}' under '/**/{node}' of a file"])
    return _Source(where, node or '/**', {name: parse(value, where)}, '' if node or namespace != '/' else text)


def _losing(sources: Sequence[_Source], node: str, namespace: str) -> Iterator[str]:
    """
    Yield the values that stand last for a node but lose.

    rcl gives a section the place where its name was first written, `-p` without a node being the section '/**'; of two
    sections for a node the one with the later place wins, whatever was written last.
    """
    places: dict[str, int] = {}
    last: dict[str, _Source] = {}
    winning: dict[str, _Source] = {}
    for source in sources:
        place = places.setdefault(source.section, len(places))
        for name in source.values if node in addressed(source.section, namespace) else ():
            last[name] = source
            if place >= places[winning.get(name, source).section]:
                winning[name] = source
    for name, source in last.items():
        winner = winning[name]
        if winner is not source and winner.values[name] != source.values[name]:
            remedy = f'-p {node}:{source.rule}' if source.rule else f"it under '{winner.section}' of a file"
            yield (f'{source.where}: {name} = {source.values[name]!r} would lose in ROS 2 against '
                   f"{winner.values[name]!r} under '{winner.section}' ({winner.where}); write {remedy}")
