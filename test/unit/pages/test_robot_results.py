"""What the robots do, in docs/robots.md: of the present files and options, and equal to what the commands measure."""

from pathlib import Path

import pytest
from robot_results import (
    PART,
    lap_command,
    result_cells,
    results_fingerprint,
    results_markdown,
    study_command,
)

from mobile_robot_control.configuration.robot_files import shipped_robots

PAGE = Path(__file__).parents[3] / 'docs' / 'robots.md'


def test_the_tables_are_of_the_present_robots():
    tables, robots = PART.found(PAGE.read_text(encoding='utf-8')), shipped_robots()
    assert f'generated from {results_fingerprint(robots)} -->' in tables
    rows = [line.split('|')[1].strip() for line in tables.splitlines() if line.startswith('| ')]
    assert rows == ['robot', *robots] * 2
    for robot, file in robots.items():
        assert f'`{lap_command(robot, file)}`' in tables
        assert f'`{study_command(robot)} --output DIR`' in tables


@pytest.mark.soak
@pytest.mark.timeout(1200)
def test_the_tables_equal_the_measurement():
    assert PART.found(PAGE.read_text(encoding='utf-8')) == results_markdown(shipped_robots())


def test_a_row_has_lengths_in_centimetres_and_calls_what_is_absent_so():
    lap = {'duration': 48.0, 'rms_position_error': 0.01234, 'max_position_error': 0.05}
    study = {'runs': 300, 'successes': 299, 'success_interval': [0.98134, 0.9994],
             'metrics': {'late_max_position_error': {'median': 0.02, '95_percent': None}},
             'margins': {'velocity_loop': None, 'position_loop': {'gain': None, 'delay': 0.2514}}}
    assert result_cells('one', lap, {'rms_position_error': 0.00123}, study) == [
        'one', '48 s', '1.23 cm', '5.00 cm', '0.12 cm', '299 of 300', '98.13 to 99.94 %', '2.00 cm', '–', '–',
        'more than 20, 251 ms']
    study['margins']['velocity_loop'] = {'gain': 3.999, 'delay': None}
    assert result_cells('one', lap, lap, study)[9] == '4.00, more than 20 periods'
