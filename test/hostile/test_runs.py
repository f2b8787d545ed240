"""A report draws what can be drawn: odd names, broken neighbours and impossible numbers hide no other run."""

import itertools
import json
import os
from xml.etree import ElementTree

import pytest

from mobile_robot_control.pages import page_parts
from mobile_robot_control.pages.page_parts import chart_scripts, replay_scripts
from mobile_robot_control.report import command as report
from mobile_robot_control.report import report_writing
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.runs.csv_table import CSV_COLUMNS
from mobile_robot_control.runs.reading import load_run
from mobile_robot_control.runs.run_figures import RUN_FIGURES, PanelOf
from mobile_robot_control.runs.run_files import UnreadableRunError

pytestmark = pytest.mark.usefixtures('quick')

NAMES = ['$', '$x^$', '\\$^_{$', '_private', 'one\ntwo\x1b[2J', '\udcff\u2028\ufffe']


@pytest.fixture(scope='module')
def table(tmp_path_factory):
    """A short run as a table."""
    file = tmp_path_factory.mktemp('runs') / 'run.csv'
    assert simulate.main(['--duration', '0.1', '--output', str(file)]) == 0
    return file


def _drawn(output):
    """Return the page of a report after checking that its figures were drawn and are XML."""
    page = (output / 'report.html').read_text(encoding='utf-8')
    assert 'could not be drawn' not in page
    files = list((output / 'figures').glob('*.svg'))
    assert files
    for file in files:
        ElementTree.parse(file)  # noqa: S314 (our own file)
    return page


def test_any_name_is_drawn_and_a_script_or_a_file_name_of_odd_bytes_is_a_text_on_the_page(table, tmp_path):
    assert report.main([*(f'{name}={table}' for name in NAMES), '--output', str(tmp_path / 'odd')]) == 0
    _drawn(tmp_path / 'odd')
    assert len(json.loads((tmp_path / 'odd' / 'report.json').read_text())) == len(NAMES)
    odd = tmp_path / 'r\udcff\n$.csv'
    os.link(table, odd)
    names = '</script><script>alert(1)</script>', '"><svg onload>', '<&">--', 'x' * 3000
    assert report.main([*(f'{name}={table}' for name in names), str(odd), '--output', str(tmp_path / 'out')]) == 0
    page = _drawn(tmp_path / 'out')
    assert 'r\\udcff\\n$' in page
    assert '&lt;script&gt;' in page
    assert '<script>alert' not in page
    assert '<svg onload' not in page
    # the blocks of numbers, and the page's own scripts
    assert page.count('</script>') == page.count('<script') == 2 + len(replay_scripts()) + len(chart_scripts())


def _read(path):
    """Read a run as the command does, without drawing it."""
    return load_run('run', path, quiet=True)


def test_broken_files_beside_a_run_are_a_problem_of_the_run_alone(table, tmp_path):
    os.link(table, tmp_path / 'run.csv')
    beside = tmp_path / 'run.parameters.yaml'
    for broken in ('/**: {ros__parameters: {robot.mass: -1.0}}', '[' * 9000, '', '/**: &a {x: *a}', '\xff\x00'):
        beside.write_text(broken, encoding='latin-1')
        run = _read(tmp_path / 'run.csv')
        assert run.parameters is None, broken
        assert any(problem.startswith('run.parameters.yaml is not read: ') for problem in run.problems), broken
    for text, outcome in (('[' * 9000, 'not known'), ('{"outcome": "\\ud800\\n$"}', r'\ud800\n$'),
                          ('{"outcome": {}}', 'not known'), ('\xff', 'not known'), ('5', 'not known'),
                          ('', 'not known')):
        (tmp_path / 'run.metrics.json').write_text(text, encoding='latin-1')
        assert _read(tmp_path / 'run.csv').metrics['outcome'] == outcome, text


def test_impossible_times_are_left_out(table, tmp_path):
    head, *rows = table.read_text().splitlines(keepends=True)
    for n, (column, time) in enumerate(itertools.product(('time', 'odom.header.stamp'),
                                                         ('1e300', '-1.0', '1e12', '3e9'))):
        cells = rows[20 + n].split(',')
        cells[CSV_COLUMNS.index(column)] = time
        rows[20 + n] = ','.join(cells)
    (tmp_path / 'odd.csv').write_text(''.join([head, *rows]))
    assert '8 rows left out: a time or a number that no run can have' in _read(tmp_path / 'odd.csv').problems


def test_a_table_without_end_is_refused(tmp_path):
    os.mkfifo(tmp_path / 'pipe.csv')
    (tmp_path / 'device.csv').symlink_to('/dev/zero')
    for name, size in (('long', 1 << 34), ('large', 1 << 38)):
        (tmp_path / f'{name}.csv').touch()
        # a hole in the file: it takes no room on the disk
        os.truncate(tmp_path / f'{name}.csv', size)
    for name, reason in (('pipe', 'is not a regular file'), ('device', 'is not a regular file'),
                         ('long', 'a line is longer'), ('large', 'is larger than a table can be')):
        with pytest.raises(UnreadableRunError, match=reason):
            _read(tmp_path / f'{name}.csv')


def test_a_figure_or_replay_that_cannot_be_made_hides_nothing_else(table, tmp_path, monkeypatch):
    def fail(_):
        raise ValueError('odd\nnumbers')

    monkeypatch.setattr(report_writing, 'RUN_FIGURES', (
        RUN_FIGURES[1]._replace(name='odd', panels=(PanelOf('x', 'm', fail),)), RUN_FIGURES[1]))
    monkeypatch.setattr(page_parts, 'replay_data', fail)
    assert report.main([str(table), '--output', str(tmp_path)]) == 0
    page = (tmp_path / 'report.html').read_text()
    assert r'could not be drawn: ValueError: odd\nnumbers' in page
    assert [file.name for file in (tmp_path / 'figures').glob('*.svg')] == [f'{RUN_FIGURES[1].name}.svg']
    assert r'cannot be shown: ValueError: odd\nnumbers' in page
    assert 'class="answer"' in page
    assert 'id="run-data"' not in page
