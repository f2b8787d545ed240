"""The tests use public names alone, and start nodes only in a ROS domain of their own."""

import ast
import re
import socket
from pathlib import Path

import pytest
import rclpy
from domains import DOMAINS, own_domain

TEST = Path(__file__).parents[1]
# how NamedTuples name what others may use, os the end of a forked process, and notebooks what shows a picture
NAMED_TUPLE = {'_replace', '_asdict', '_fields', '_exit', '_repr_png_'}


def _is_private(name):
    return name.startswith('_') and not name.endswith('__') and name not in NAMED_TUPLE


def private_names(text):
    """Yield the private names of other modules and objects that a test module reaches into."""
    for node in ast.walk(ast.parse(text)):
        names = []
        if isinstance(node, ast.Attribute):
            own = isinstance(node.value, ast.Name) and node.value.id in {'self', 'cls'}
            names = [] if own else [node.attr]
        elif isinstance(node, ast.Import | ast.ImportFrom):
            imported = [alias.name for alias in node.names] + [getattr(node, 'module', None) or '']
            names = [part for name in imported for part in name.split('.')]
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith('attr'):
            # getattr, setattr and monkeypatch's
            names = [argument.value for argument in node.args[1:2] if isinstance(argument, ast.Constant)]
        yield from filter(_is_private, names)


def test_no_test_reaches_into_private_names():
    found = {(str(path.relative_to(TEST)), name) for path in TEST.rglob('*.py')
             for name in private_names(path.read_text(encoding='utf-8'))}
    assert not found


def test_rclpy_is_entered_as_every_supported_distribution_can():
    """On Jazzy `rclpy.init` returns nothing that `with` could leave; what it leaves behind breaks other tests."""
    entered = re.compile(r'^ *with rclpy\.init', re.MULTILINE)
    assert not [path for path in TEST.rglob('*.py') if entered.search(path.read_text(encoding='utf-8'))]


def test_without_the_fixture_domain_no_node_starts():
    with pytest.raises(RuntimeError, match='ROS_DOMAIN_ID'):
        rclpy.init()


def test_no_test_is_given_a_domain_in_which_somebody_left_a_node():
    with own_domain() as found:
        left = int(found['ROS_DOMAIN_ID'])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as node:
        node.bind(('127.0.0.1', 7410 + 250 * left))
        for _ in DOMAINS:
            with own_domain() as one, own_domain() as another:
                assert len({one['ROS_DOMAIN_ID'], another['ROS_DOMAIN_ID'], str(left)}) == 3
