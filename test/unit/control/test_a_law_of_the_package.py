"""A law is added to the package itself by one file and one line."""

import ast
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import mobile_robot_control
from mobile_robot_control.control.laws import BUILT_IN

PACKAGE = Path(mobile_robot_control.__file__).parent
KANAYAMA = Path(__file__).parents[2] / 'plugins' / 'kanayama.py'


def test_a_law_is_one_file_and_one_line(tmp_path):
    copy = tmp_path / PACKAGE.name
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copy(KANAYAMA, copy / 'control' / 'my_kanayama.py')
    laws = copy / 'control' / 'laws.py'
    laws.write_text(laws.read_text().replace("    'fuzzy',\n", "    'fuzzy',\n    'my_kanayama',\n"))
    done = subprocess.run(
        [sys.executable, '-m', 'mobile_robot_control.cli.simulate', '--duration', '0.1', '--json', '-p',
         'position_controller.controller_type:=my_kanayama', '-p', 'position_controller.my_kanayama.p:=3.0'],
        capture_output=True, text=True, check=False, cwd=tmp_path, env=os.environ | {'PYTHONPATH': str(tmp_path)})
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)['outcome'] == 'completed'
    helped = subprocess.run(
        [sys.executable, '-c', 'from mobile_robot_control.tuning.search_space import SEARCHES; print([*SEARCHES])'],
        capture_output=True, text=True, check=True, cwd=tmp_path, env=os.environ | {'PYTHONPATH': str(tmp_path)})
    laws_before = [law.name for law in BUILT_IN]
    assert ast.literal_eval(helped.stdout) == ['velocity', *laws_before[:3], 'my_kanayama', *laws_before[3:]]
