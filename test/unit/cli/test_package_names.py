"""The names of the package: all of them are there, and type checkers get the same."""

import ast
import importlib
from pathlib import Path

import numpy as np
import pytest

import mobile_robot_control as mrc
from mobile_robot_control.settings.files import read_override

PACKAGE = Path(mrc.__file__).parent


def test_every_name_is_there_and_is_what_type_checkers_see():
    tree = ast.parse((PACKAGE / '__init__.pyi').read_text(encoding='utf-8'))
    typed = {alias.asname: (node.module, alias.name) for node in tree.body for alias in node.names}
    assert sorted(typed) == sorted(mrc.__all__)
    for name, (module, original) in typed.items():
        assert getattr(mrc, name) is getattr(importlib.import_module(module), original), name
    assert (PACKAGE / 'py.typed').is_file()


@pytest.mark.parametrize(('value', 'read'), [
    (np.float64(0.1), 0.1), (np.int64(3), 3), (np.array([0.1, 0.2]), [0.1, 0.2]), ((1, 0.5), [1.0, 0.5]),
    ((True, False), [True, False]), ('1e-3', '1e-3'), ('true', 'true'), (1e-07, 1e-07), ([], []),
])
def test_values_from_python_are_those_that_yaml_would_give(value, read):
    assert repr(read_override(('plant.name', value))[2]) == repr({'name': read})


def test_the_names_of_laws_and_curves_are_listed():
    assert {'backstepping', 'lqr'} <= set(mrc.LAWS)
    assert {'trifolium', 'line'} <= set(mrc.CURVES)
