"""The names of the package: all of them are there, and type checkers get the same."""

import ast
import importlib
import inspect
from pathlib import Path

import pytest
from typed_names import typed_names

import mobile_robot_control as mrc
from mobile_robot_control.benchmarking.request import BenchmarkRequest
from mobile_robot_control.identification.request import IdentificationRequest
from mobile_robot_control.parameters.requests import options_of
from mobile_robot_control.planning.request import PlanRequest
from mobile_robot_control.runs.request import SimulationRequest
from mobile_robot_control.search.request import SearchRequest
from mobile_robot_control.studying.request import StudyRequest

PACKAGE = Path(mrc.__file__).parent
KEYWORD = inspect.Parameter.KEYWORD_ONLY


def test_every_name_is_there_and_is_what_type_checkers_see():
    text = (PACKAGE / '__init__.pyi').read_text(encoding='utf-8')
    assert text == typed_names(), 'make pages writes it again'
    tree = ast.parse(text)
    typed = {alias.asname: (node.module, alias.name) for node in tree.body if isinstance(node, ast.ImportFrom)
             for alias in node.names if alias.asname}
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    assert sorted([*typed, *functions]) == sorted(mrc.__all__)
    for name, (module, original) in typed.items():
        assert getattr(mrc, name) is getattr(importlib.import_module(module), original), name
    for name, node in functions.items():
        assert [one.arg for one in node.args.kwonlyargs] == [
            one.name for one in inspect.signature(getattr(mrc, name)).parameters.values() if one.kind == KEYWORD], name
    assert (PACKAGE / 'py.typed').is_file()


@pytest.mark.parametrize(('function', 'request_type'), [
    (mrc.simulate, SimulationRequest), (mrc.tune, SearchRequest), (mrc.study, StudyRequest),
    (mrc.benchmark, BenchmarkRequest), (mrc.plan, PlanRequest), (mrc.identify, IdentificationRequest),
])
def test_a_function_takes_and_explains_the_fields_of_its_request_with_their_defaults(function, request_type):
    parameters, renamed = inspect.signature(function).parameters, {'topic': 'topics'}
    # in Python a collection may also be a mapping, a path, or None
    others = {'compare', 'bounds', 'map', 'topics'}
    for name, option in options_of(request_type).items():
        shown = parameters[renamed.get(name, name)]
        assert shown.name in others or shown.default == (
            inspect.Parameter.empty if option.is_required else option.default), name
    section = function.__doc__.partition('Parameters\n----------\n')[2].partition('\n\n')[0]
    assert [line.partition(' : ')[0].strip('*') for line in section.splitlines() if line[0] != ' '] == [*parameters]
    for option in options_of(request_type).values():
        if option.field.unit and option.name in parameters:
            assert f'[{option.field.unit}]' in section.partition(f'{option.name} : ')[2]


def test_the_names_of_laws_and_curves_are_listed():
    assert {'backstepping', 'lqr'} <= set(mrc.LAWS)
    assert {'trifolium', 'line'} <= set(mrc.CURVES)
