"""The addressing of the four nodes by sections of a parameter file, through their full names."""

import re
from collections.abc import Mapping

from mobile_robot_control.configuration.nodes import NODES

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


def elsewhere(section: str, names: Mapping[str, str]) -> str:
    """Explain why a section is for one of the four nodes in another namespace, with the remedy; '' if it is not."""
    node = section.rpartition('/')[2]
    if node not in names:
        return ''
    return (f"reaches no node in the namespace '{namespace_of(names[node])}': section '{section}' is for another one; "
            f"write '/**/{names[node].rpartition('/')[2]}'")


def namespace_fault(text: str) -> str:
    """Describe the fault in a namespace, with the remedy; '' if ROS accepts it."""
    if _is_namespace(text):
        return ''
    near = '/' + '/'.join(filter(None, text.split('/')))
    return (f"'{text}' is no namespace of ROS (letters, digits and single '_' between single '/', at most "
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
