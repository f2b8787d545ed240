"""The SROS2 policy: topics and services that each node may use, from the table of topics."""

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from mobile_robot_control.settings.files import namespace_fault
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.topics import (
    ALL_LOOP_TOPICS,
    CORRECTION,
    DISTURBANCE,
    GOAL,
    LOOPS,
    OTHER_INPUTS,
    OTHER_TOPICS,
    PATH_TOPIC,
    SHARED_TOPICS,
    STOPPED,
    extended,
)

_VERSION = '0.2.0'  # of the schema: https://github.com/ros2/sros2/blob/0.13.0/sros2/sros2/policy/schemas/policy.xsd
_ENCLAVES = '/mobile_robot_control'
_RECORDER, _REPLAYER = 'recorder', 'replayer'
_SERVICES = ('describe_parameters', 'get_parameter_types', 'get_parameters', 'get_type_description',
             'list_parameters', 'set_parameters', 'set_parameters_atomically')
"""Services of every ROS 2 node."""
_OWN_SERVICES = {'plant': ('reset', 'step'), 'position_controller': ('stop', 'release')}
"""Further services of a node."""
_HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<!-- Generated from the table of topics: python -m mobile_robot_control.settings.sros2_policy FILE [NAMESPACE] -->
<!-- How it is used: docs/security.md -->
"""


class _Permissions(NamedTuple):
    publish: Iterable[str]
    subscribe: Iterable[str]
    request: Iterable[str] = ()
    reply: Iterable[str] = _SERVICES


def policy(namespace: str = '/') -> str:
    """
    Return the policy of a robot's nodes and of those of `experiment` as XML.

    Each node has its own enclave. The enclave `experiment` contains them all, for processes that share one.

    Parameters
    ----------
    namespace : str
        Of the robot's nodes.

    """
    room = f'{_ENCLAVES}{namespace.rstrip("/")}'
    permissions = {node: _of_node(node) for node in NODES}
    experiment = {_RECORDER: _of_recorder(), _REPLAYER: _of_replayer()}
    enclaves = [
        *(_enclave(f'{room}/{node}', namespace, {node: allowed}) for node, allowed in permissions.items()),
        _enclave(f'{room}/experiment', namespace, permissions | experiment),
    ]
    lines = [f'<policy version="{_VERSION}">', '  <enclaves>', *(line for one in enclaves for line in one),
             '  </enclaves>', '</policy>']
    return _HEAD + '\n'.join(lines) + '\n'


def _of_node(node: str) -> _Permissions:
    loop = [topic.name for topic in ALL_LOOP_TOPICS.values() if topic.publisher == node]
    others = [topic for topic, publishers in OTHER_TOPICS.items() if node in publishers]
    graphs = [extended(graph, horizon=True, feeds=True, timed=True) for graph in LOOPS.values()]
    inputs = dict.fromkeys(topic for graph in graphs for topic in graph.inputs_of(node))
    if node == 'plant':  # in a stall, it looks for the silent link
        inputs |= dict.fromkeys(answer for graph in graphs for _, answer in graph.answers)
    # rclpy itself subscribes to /clock if use_sim_time is true
    inputs |= dict.fromkeys(topic for topic, nodes in OTHER_INPUTS.items() if node in nodes)
    if node == 'position_controller':  # beside another one of its name
        inputs |= dict.fromkeys(('cmd_vel', STOPPED))
    if node in OTHER_INPUTS[CORRECTION]:
        inputs |= dict.fromkeys(('/tf', '/tf_static'))
    return _Permissions([*loop, *others], [*inputs, '/clock'],
                        reply=[*_SERVICES, *_OWN_SERVICES.get(node, ())])


def _of_recorder() -> _Permissions:
    """Return the permissions of the recorder: it records all topics, and holds and resumes the plant."""
    recorded = dict.fromkeys([*ALL_LOOP_TOPICS, *OTHER_TOPICS, *OTHER_INPUTS, *SHARED_TOPICS])
    return _Permissions(['/parameter_events'], recorded, ['plant/set_parameters'])


def _of_replayer() -> _Permissions:
    """Return the permissions of the node of `mrc experiment --replay`: it repeats the changes of a run."""
    return _Permissions(['/parameter_events', DISTURBANCE, PATH_TOPIC, GOAL, CORRECTION], [], [
        *(f'{node}/set_parameters_atomically' for node in NODES), 'plant/reset'])


def _enclave(path: str, namespace: str, nodes: dict[str, _Permissions]) -> Iterator[str]:
    """Yield the lines of an enclave with the profiles of some nodes."""
    yield from (f'    <enclave path="{path}">', '      <profiles>')
    for node, allowed in nodes.items():
        yield f'        <profile ns="{namespace}" node="{node}">'
        yield from _allowance('topic', 'publish', allowed.publish)
        yield from _allowance('topic', 'subscribe', allowed.subscribe)
        yield from _allowance('service', 'reply', [f'~/{service}' for service in allowed.reply])
        yield from _allowance('service', 'request', allowed.request)
        yield '        </profile>'
    yield from ('      </profiles>', '    </enclave>')


def _allowance(kind: str, verb: str, names: Iterable[str]) -> Iterator[str]:
    """Yield the lines that allow one thing; none without names, since the schema does not allow an empty list."""
    lines = [f'            <{kind}>{name}</{kind}>' for name in names]
    if lines:
        yield from (f'          <{kind}s {verb}="ALLOW">', *lines, f'          </{kind}s>')


def write_policy(arguments: list[str]) -> int:
    """Write the policy to the file in the first argument, for the namespace in the second; return an exit code."""
    file, namespace = (*arguments, '/')[:2] if len(arguments) in (1, 2) else ('', '/')
    fault = namespace_fault(namespace) if file else 'give a file and, where the robot has one, a namespace'
    if not fault:
        try:
            Path(file).write_text(policy(namespace), encoding='utf-8')
        except OSError as error:
            fault = f"'{file}' cannot be written ({error.strerror}); name a file in a folder that exists"
    if fault:
        print(f'sros2_policy: {fault}', file=sys.stderr)
    return 2 if fault else 0


if __name__ == '__main__':
    sys.exit(write_policy(sys.argv[1:]))
