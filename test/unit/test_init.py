"""The names of the package: all of them are there, and type checkers get the same."""

import ast
import importlib
from pathlib import Path

import mobile_robot_control as mrc

PACKAGE = Path(mrc.__file__).parent


def test_every_name_is_there_and_is_what_type_checkers_see():
    tree = ast.parse((PACKAGE / '__init__.pyi').read_text(encoding='utf-8'))
    typed = {alias.asname: (node.module, alias.name) for node in tree.body for alias in node.names}
    assert sorted(typed) == sorted(mrc.__all__)
    for name, (module, original) in typed.items():
        assert getattr(mrc, name) is getattr(importlib.import_module(module), original), name
    assert (PACKAGE / 'py.typed').is_file()


def test_the_names_of_laws_and_curves_are_listed():
    assert {'backstepping', 'lqr'} <= set(mrc.LAWS)
    assert {'trifolium', 'line'} <= set(mrc.CURVES)
