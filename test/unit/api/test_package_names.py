"""The names of the package: all of them are there, and type checkers get the same."""

import ast
import importlib
from pathlib import Path

import numpy as np
import pytest

import mobile_robot_control as mrc
from mobile_robot_control.api.command_lines import as_yaml
from mobile_robot_control.parameters.rcl_yaml import parse_yaml

PACKAGE = Path(mrc.__file__).parent


def test_every_name_is_there_and_is_what_type_checkers_see():
    tree = ast.parse((PACKAGE / '__init__.py').read_text(encoding='utf-8'))
    typed = {alias.asname: (node.module, alias.name) for branch in tree.body if isinstance(branch, ast.If)
             for node in branch.body for alias in node.names}
    assert sorted([*typed, '__version__']) == sorted(mrc.__all__)
    for name, (module, original) in typed.items():
        assert getattr(mrc, name) is getattr(importlib.import_module(module), original), name
    assert (PACKAGE / 'py.typed').is_file()


@pytest.mark.parametrize('value', [3.0, 1e-07, -2, True, 'it\'s: "odd" # yes', '1e-3', 'true', [0.1, 1e-300], []])
def test_a_value_reads_back_the_same(value):
    assert repr(parse_yaml(as_yaml(value), 'test')) == repr(value)


@pytest.mark.parametrize(('value', 'read'), [
    (np.float64(0.1), 0.1), (np.int64(3), 3), (np.array([0.1, 0.2]), [0.1, 0.2]), ((1, 0.5), [1.0, 0.5]),
    ((True, False), [True, False]), (Path('a b'), 'a b'),
])
def test_numpy_and_tuples_are_read_as_what_they_contain(value, read):
    assert repr(parse_yaml(as_yaml(value), 'test')) == repr(read)


def test_the_names_of_laws_and_curves_are_listed():
    assert {'backstepping', 'lqr'} <= set(mrc.LAWS)
    assert {'trifolium', 'line'} <= set(mrc.CURVES)
