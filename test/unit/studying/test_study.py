"""`study` in Python gives the numbers of the command for the same seed."""

import csv
import json

import numpy as np
import pytest
from helpers.harness import numbers_in

import mobile_robot_control as mrc
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.scenarios import Scenario
from mobile_robot_control.studying import command as study
from mobile_robot_control.studying import engine

# a loop so short that plain Python runs it in a few milliseconds
SMALL = {'/**.velocity_rate': 100.0, '/**.position_rate': 50.0, 'reference_cart.period': 0.5,
         'reference_cart.scale': 0.05}
SHORT = [word for name, value in SMALL.items() for word in ('-p', f'{name}:={value}')]


@pytest.fixture(autouse=True)
def uncompiled(monkeypatch):
    monkeypatch.setattr(batch, 'COMPILES', False)


def test_every_law_is_studied_in_the_same_scenarios(monkeypatch):
    # the margins of one stand for those of all, which take a second
    promised = engine.promise(mrc.configure({}), [Scenario('circle', 1.0)])
    monkeypatch.setattr(engine, 'promise', lambda *_: promised)
    found = mrc.study(runs=2, seed=1, parameters=SMALL, laps=0.4, workers=1, compare={
        law: {'position_controller.controller_type': law} for law in LAWS})
    assert list(found.controllers) == list(LAWS)
    assert set(found.runs['outcome']) == {'completed'}
    assert len(set(found.runs['rms_position_error'])) == 2 * len(LAWS)
    assert len(found.comparisons) == len(LAWS) * (len(LAWS) - 1) // 2


OPTIONS = {'scales': [0.05, 0.1], 'within': 0.5, 'longest_delay': 2, 'noise_pose': (0.01, 0.01, 0.0), 'laps': 1.5}


def _file(folder, gain):
    file = folder / f'gain_{gain}.yaml'
    file.write_text(f'/**/position_controller: {{ros__parameters: {{backstepping: {{p: {gain}}}}}}}')
    return file


def test_a_study_has_the_numbers_of_the_command(tmp_path):
    files = [_file(tmp_path, gain) for gain in (2.0, 0.5)]
    assert study.main(['--runs', '5', '--seed', '1', *SHORT, '--scales', '0.05', '0.1', '--within', '0.5',
                       '--longest-delay', '2', '--noise-pose', '0.01', '0.01', '0', '--laps', '1.5', '--workers', '1',
                       '--compare', *map(str, files), '--output', str(tmp_path / 'out')]) == 0
    found = mrc.study(runs=5, seed=1, parameters=SMALL, compare=files, workers=1, **OPTIONS)
    assert found.values == numbers_in(tmp_path / 'out' / 'study.json')
    made = json.loads((tmp_path / 'out' / 'study.json').read_text())['provenance']
    assert made['parameters'] == json.loads(json.dumps(found.provenance['parameters']))
    assert made['parameters']['gain_2.0']['position_controller']['backstepping.p'] == 2.0
    with (tmp_path / 'out' / 'runs.csv').open() as table:
        rows = list(csv.DictReader(table))
    assert list(found.runs) == list(rows[0])
    assert list(found.runs['controller']) == [row['controller'] for row in rows]
    assert np.array_equal(found.runs['objective'], [float(row['objective']) for row in rows])
    assert found.runs['success'].dtype == bool
    by_name = mrc.study(runs=5, seed=1, parameters=SMALL, workers=1, **OPTIONS, compare={
        'file': files[0], 'given': {'position_controller.backstepping.p': 0.5}})
    assert list(by_name.controllers) == ['file', 'given']
    comparison, = by_name.comparisons
    assert (comparison['first'], comparison['second'], comparison['runs']) == ('file', 'given', 5)
    assert by_name.controllers['file']['failures']['count'] == 5 - by_name.controllers['file']['successes']
    assert set(by_name.runs['outcome']) == {'completed'}
    assert list(by_name.controllers.values()) == list(found.controllers.values())


def test_a_study_is_reported_printed_and_needs_no_list_for_one_file_curve_or_scale(tmp_path):
    file = _file(tmp_path, 0.5)
    alone, listed = (mrc.study(runs=2, seed=1, parameters=SMALL, laps=0.5, workers=1, **options) for options in (
        {'compare': file, 'curves': 'circle', 'scales': 0.05},
        {'compare': {'gain_0.5': file}, 'curves': ['circle'], 'scales': [0.05]}))
    assert alone.values == listed.values
    page = alone.report(tmp_path / 'studied')
    assert page.html == (tmp_path / 'studied' / 'study.html').read_text()
    assert numbers_in(tmp_path / 'studied' / 'study.json')['controllers']['gain_0.5']['runs'] == 2
    alone.controllers['a\nb'] = one = alone.controllers.pop('gain_0.5')
    one.update(successes=1, runs=2, success_interval=[0.09453120573423379, 0.9054687942657662])
    one['metrics']['rms_position_error']['median'] = 0.0125
    assert repr(alone) == (
        '<Study: seed 1, success is within 0.1 m over the last quarter\n'
        '  a\\nb: 1 of 2 runs succeeded (95 % interval 9.453 to 90.55 %), median RMS position error 0.0125 m>')
    one['metrics']['rms_position_error']['median'] = None
    assert repr(alone).endswith('90.55 %)>')
