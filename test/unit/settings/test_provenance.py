"""What results record about how they were made."""

import json
import platform
import subprocess
from importlib import metadata

import numpy as np
import pytest

import mobile_robot_control as mrc
from mobile_robot_control.report import command as report
from mobile_robot_control.report import report_writing
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.runs.run_figures import RUN_FIGURES
from mobile_robot_control.settings import provenance

SHORT = ['--duration', '0.1', '-p', 'position_controller.backstepping.p:=2.5', '-p', 'plant.noise.seed:=7']


@pytest.fixture
def table(tmp_path):
    assert simulate.main([*SHORT, '--output', str(tmp_path / 'a run.csv')]) == 0
    return tmp_path / 'a run.csv'


def test_a_run_records_its_command_its_versions_and_all_parameters(table):
    found = json.loads(table.with_suffix('.metrics.json').read_text())['provenance']
    assert found['command_line'] == ("mrc simulate --duration 0.1 -p position_controller.backstepping.p:=2.5 -p "
                                     f"plant.noise.seed:=7 --output '{table}'")
    assert found['versions']['mobile_robot_control'] == mrc.__version__
    assert found['versions']['python'] == platform.python_version()
    assert found['versions']['numpy'] == np.__version__
    assert found['versions']['rclpy'] == metadata.version('rclpy')
    assert found['parameters']['position_controller']['backstepping.p'] == 2.5
    assert (found['parameters']['plant']['noise.seed'], found['parameters']['plant']['duration']) == (7, 0.1)
    assert mrc.load(table).provenance == found


def test_a_report_records_how_it_was_made_in_its_json_and_on_its_page(table, tmp_path, monkeypatch):
    monkeypatch.setattr(report_writing, 'RUN_FIGURES', RUN_FIGURES[:1])
    assert report.main([f'<x>={table}', '--output', str(tmp_path / 'out')]) == 0
    made = json.loads((tmp_path / 'out' / 'report.json').read_text())['<x>']['provenance']
    assert made['command_line'] == f"mrc report '<x>={table}' --output {tmp_path / 'out'}"
    assert made['parameters']['plant']['noise.seed'] == 7
    page = (tmp_path / 'out' / 'report.html').read_text()
    fold = page.partition('<summary>How this was made</summary>')[2].partition('</details>')[0]
    assert '&lt;x&gt;=' in fold
    assert f'python {platform.python_version()}' in fold


def test_results_in_python_record_their_call():
    parameters = {'plant.noise.velocity': 0.05}
    run = mrc.simulate(duration=0.1, parameters=parameters)
    assert run.provenance['command_line'] == (
        "mobile_robot_control.simulate(duration=0.1, parameters={'plant.noise.velocity': 0.05})")
    assert run.provenance['parameters']['plant']['noise.velocity'] == 0.05


def test_the_commit_is_that_of_a_checkout_and_of_no_other(tmp_path, monkeypatch):
    for words in (['init', '-q'],
                  ['-c', 'user.name=x', '-c', 'user.email=x', 'commit', '-q', '--allow-empty', '-m', 'x']):
        subprocess.run(['git', *words], cwd=tmp_path, check=True)
    head = subprocess.run(['git', 'rev-parse', 'HEAD'], cwd=tmp_path, capture_output=True, text=True, check=True)
    (tmp_path / 'inner').mkdir()
    for checkout, expected in ((tmp_path, head.stdout.strip()), (tmp_path / 'inner', None)):
        monkeypatch.setattr(provenance, 'CHECKOUT', checkout)
        provenance.versions.cache_clear()
        assert provenance.versions()['commit'] == expected
    monkeypatch.undo()
    provenance.versions.cache_clear()
