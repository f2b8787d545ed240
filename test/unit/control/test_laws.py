"""The position laws by name: selected, refused, and a new one added."""

import ast
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import mobile_robot_control
from mobile_robot_control.control import fuzzy, hybrid_backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.laws import BUILT_IN, LAWS, RESERVED, PositionControl, law_violations, select
from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.settings.files import is_ros_parameter
from mobile_robot_control.settings.nodes import PositionControllerParameters

GENTLE = PositionControl(backstepping=BacksteppingGains(p=1.0, q=1.0, f=1.0, g=1.0))
HYBRID = GENTLE._replace(controller_type='hybrid_backstepping')


@pytest.mark.parametrize(('parameters', 'function', 'gains'), [
    (HYBRID, hybrid_backstepping.step, (GENTLE.backstepping, GENTLE.hybrid_backstepping)),
    (GENTLE._replace(controller_type='fuzzy'), fuzzy.step, GENTLE.fuzzy),
])
def test_select_gives_the_law_with_its_gains(parameters, function, gains):
    law, selected = select(parameters, 0.01)
    assert (law.step, selected) == (function, gains)


def test_the_names_that_no_law_may_have_are_those_of_the_node():
    first_words = {name.partition('.')[0] for name in declarations(PositionControllerParameters)} - set(LAWS)
    assert first_words <= RESERVED
    assert not any(is_ros_parameter(name) for name in LAWS)


def test_a_law_may_have_any_name_that_the_node_leaves(registered):
    LAWS.register(fuzzy.LAW._replace(name='self'))
    assert PositionControl(controller_type='self', **{'self': fuzzy.FuzzyGains()})._replace(
        controller_type='fuzzy').controller_type == 'fuzzy'


def test_parameters_are_equal_where_all_of_them_are():
    assert GENTLE == GENTLE._replace() != HYBRID
    assert GENTLE.backstepping != GENTLE


@pytest.mark.parametrize('horizon', [-1, 1.5])
def test_a_law_whose_horizon_is_no_number_of_ticks_is_refused(horizon):
    refusal, = law_violations(LAWS['fuzzy']._replace(horizon=horizon))
    assert refusal == f"'fuzzy': its horizon is {horizon}; write the number of position ticks ahead"


def test_a_law_is_one_file_and_one_line_in_the_package(tmp_path):
    package = Path(mobile_robot_control.__file__).parent
    copy = tmp_path / package.name
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copy(Path(__file__).parents[2] / 'plugins' / 'kanayama.py', copy / 'control' / 'my_kanayama.py')
    laws = copy / 'control' / 'laws.py'
    laws.write_text(laws.read_text().replace("    'fuzzy',\n", "    'fuzzy',\n    'my_kanayama',\n"))

    def run(*arguments):
        return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=True, cwd=tmp_path,
                              env=os.environ | {'PYTHONPATH': str(tmp_path)}).stdout

    done = run('-m', 'mobile_robot_control.runs.command', '--duration', '0.1', '--json', '-p',
               'position_controller.controller_type:=my_kanayama', '-p', 'position_controller.my_kanayama.p:=3.0')
    assert json.loads(done)['outcome'] == 'completed'
    searches = run('-c', 'from mobile_robot_control.search.space import SEARCHES; print([*SEARCHES])')
    before = [law.name for law in BUILT_IN]
    assert ast.literal_eval(searches) == ['velocity', *before[:3], 'my_kanayama', *before[3:]]
