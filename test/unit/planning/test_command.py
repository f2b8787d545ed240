"""The command `plan`: its table, its numbers and its page agree, and faults are named."""

import csv
import json

import pytest

import mobile_robot_control as mrc
from mobile_robot_control.planning import command as plan

TIMING = {'reference_cart.timing.max_linear_velocity': 0.5, 'reference_cart.timing.max_wheel_torque': 0.3}
CLOSED = {'reference_cart.path.closed': True, **TIMING}


@pytest.fixture
def square(tmp_path):
    file = tmp_path / 'square.csv'
    file.write_text('x,y,speed\n0,0\n1,0\n1,0\n1,1\n0,1,0.2\n')
    return file


def _run(file, folder, values):
    return plan.main([str(file), '--output', str(folder), *(
        word for name, value in values.items() for word in ('-p', f'{name}:={str(value).lower()}'))])


def test_table_numbers_and_page_are_those_of_the_function_and_dry_friction_is_among_the_torques(
    square, tmp_path, capsys
):
    assert _run(square, tmp_path / 'plan', CLOSED) == 0
    assert 'plan.html' in capsys.readouterr().out
    planned = mrc.plan(square, parameters=CLOSED)
    with (tmp_path / 'plan' / 'plan.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == list(plan.COLUMNS)
    assert [float(row['v']) for row in rows] == planned.velocity[:, 0].tolist()
    assert [row['limit'] for row in rows] == planned.limit
    numbers = json.loads((tmp_path / 'plan' / 'plan.json').read_text())
    assert numbers['duration'] == planned.duration == float(rows[-1]['time'])
    assert numbers['active'] == planned.active
    # in each corner
    assert numbers['deviation'] == planned.deviation == pytest.approx(0.05, abs=1e-3)
    assert sum(planned.active.values()) == pytest.approx(1.0)
    assert numbers['limits']['max_wheel_torque'] == 0.3
    page = (tmp_path / 'plan' / 'plan.html').read_text()
    assert not [name for name in ('waypoint speed', 'wheel torque', 'Plan of square.csv') if name not in page]
    # half of the motors' torque is planned with
    assert abs(planned.wheel_torque).max() == pytest.approx(0.15, rel=1e-3)
    # counter-clockwise
    assert 'The 4 waypoints are within 5 cm of the path; 1 repeated' in page
    assert (planned.wheel_velocity[:, 0] >= planned.wheel_velocity[:, 1] - 1e-9).all()
    slower = mrc.plan(square, parameters={**CLOSED, '/**.friction.coulomb': 0.05})
    assert slower.duration > planned.duration
    assert abs(slower.wheel_torque).max() == pytest.approx(0.15, rel=1e-3)


@pytest.mark.parametrize(('text', 'options', 'words'), [
    ('0,0\n', {}, 'square.csv: has 1 waypoint'),
    ('0,0\n1,0\n0,0\n', {}, 'square.csv:2: the path turns back'),
    ('0,0\n1,0\n', {'timing.max_wheel_torque': 0.0}, 'needs a limit of the acceleration'),
    ('0,0\n1,0\n', {'timing.max_linear_velocity': 0.0}, 'needs a limit of the speed'),
    ('0,0\n1,0\n', {'scale': 2.0}, 'scale = 2.0 places a curve'),
    ('0,0\n1,0\n', {'path.laps': 2}, 'path.laps = 2 needs path.closed = true'),
])
def test_what_cannot_be_planned_is_refused(square, tmp_path, capsys, text, options, words):
    square.write_text(text)
    values = TIMING | {f'reference_cart.{name}': value for name, value in options.items()}
    assert _run(square, tmp_path / 'plan', values) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / 'plan').exists()
