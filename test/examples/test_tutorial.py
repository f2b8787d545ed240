"""The tutorial notebook: it runs, its stored outputs are those of a fresh run, each exercise has an answer."""

import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.notebooks import disagreements

FOLDER = Path(__file__).parents[2] / 'examples' / 'tutorial'
NOTEBOOK = FOLDER / 'trajectory_tracking.ipynb'
STORED = json.loads(NOTEBOOK.read_text(encoding='utf-8'))
CELLS = {cell['id']: cell for cell in STORED['cells']}
ORDER = list(CELLS)
SECTIONS, EXERCISES = range(1, 9), range(1, 11)


def _source(name):
    return ''.join(CELLS[name]['source'])


@pytest.fixture
def execute():
    """The module that executes the notebook."""
    for needed in ('nbclient', 'ipykernel', 'pandas', 'numba'):
        pytest.importorskip(needed)
    spec = importlib.util.spec_from_file_location('execute', FOLDER / 'execute.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.soak
def test_the_notebook_runs_and_shows_what_is_stored(execute):
    import nbformat

    stored = nbformat.read(NOTEBOOK, as_version=4)
    assert not list(disagreements(stored, execute.executed(stored)))


def _small(source):
    cell = {'cell_type': 'code', 'id': 'one', 'metadata': {}, 'source': source, 'outputs': [], 'execution_count': None}
    return {'cells': [cell], 'metadata': STORED['metadata'], 'nbformat': 4, 'nbformat_minor': 5}


def test_outputs_are_written_without_a_trace_of_the_machine_unless_a_cell_fails(execute, tmp_path, monkeypatch, capsys):
    # a kernel of the user, and settings that would change outputs
    kernel = tmp_path / 'kernels' / 'python3'
    kernel.mkdir(parents=True)
    (kernel / 'kernel.json').write_text('{"argv": ["/nowhere"], "display_name": "odd", "language": "python"}')
    monkeypatch.setenv('JUPYTER_PATH', str(tmp_path))
    monkeypatch.setenv('MOBILE_ROBOT_CONTROL_LAWS', 'nowhere.py')
    file, failing = tmp_path / 'small.ipynb', tmp_path / 'failing.ipynb'
    file.write_text(json.dumps(_small('import os\n"MOBILE_ROBOT_CONTROL_LAWS" in os.environ')))
    assert execute.main(file) == 0
    made = json.loads(file.read_text())
    assert made['metadata'] == STORED['metadata']
    cell, = made['cells']
    assert (cell['metadata'], cell['outputs'][0]['data']) == ({}, {'text/plain': ['False']})
    wrong = "mrc.simulate(duration=1.0, parameters={'plant.max_wheel_torqe': 1.0})"
    before = json.dumps(_small(f'import mobile_robot_control as mrc\n{wrong}'))
    failing.write_text(before)
    assert execute.main(failing) == 1
    assert failing.read_text() == before
    told = capsys.readouterr().err
    assert 'failing.ipynb: ' in told
    # a wrong parameter costs at most five lines
    shown = told.partition(f'ParameterError\nline 2: {wrong}\n')[2].strip().splitlines()
    assert 0 < len(shown) <= 4
    assert "did you mean 'max_wheel_torque'?" in shown[0]


def test_each_section_and_exercise_has_its_cells_in_order():
    """A section: its question, its claims, what was seen; an exercise: an answer with a text and a cell that ran."""
    tasks = [f'exercise-{number}' for number in EXERCISES]
    answers = [name for number in EXERCISES for name in (f'answer-{number}', f'answer-{number}-code')]
    parts = [f'{part}-{number}' for number in SECTIONS for part in ('section', 'claims', 'seen')]
    assert [name for name in ORDER if re.fullmatch(r'(section|claims|seen|exercise|answer)-\d+(-code)?', name)] == [
        *parts, *tasks, *answers]
    for number in SECTIONS:
        assert re.match(rf'## {number}\. .*\?\n', _source(f'section-{number}') + '\n')
        assert 'assert ' in _source(f'claims-{number}')
        assert _source(f'seen-{number}').startswith('**Seen.** ')
    for number in EXERCISES:
        assert _source(f'exercise-{number}').startswith(f'**Exercise {number}.** ')
        assert _source(f'answer-{number}').startswith(f'**Answer {number}.** ')
        assert CELLS[f'answer-{number}-code']['outputs']


def test_it_is_stored_as_executed_from_top_to_bottom_with_pictures_and_without_warnings():
    code = [cell for cell in STORED['cells'] if cell['cell_type'] == 'code']
    assert [cell['execution_count'] for cell in code] == list(range(1, len(code) + 1))
    outputs = [output for cell in code for output in cell['outputs']]
    assert {output.get('name', 'stdout') for output in outputs} == {'stdout'}
    assert sum('image/png' in output.get('data', {}) for output in outputs) >= 12
    # and no place of a machine
    assert not re.search(r'"[^"]{0,200}(?:/tmp/|/home/|/root/|/usr/|Users)', NOTEBOOK.read_text(encoding='utf-8'))
    assert not any(cell['metadata'] for cell in STORED['cells'])


def test_the_version_for_students_has_no_answers_and_room_for_theirs(tmp_path):
    file = tmp_path / 'student.ipynb'
    for code in (0, 2):  # the second time it is there
        assert subprocess.run([sys.executable, FOLDER / 'student.py', file], check=False).returncode == code
    made = json.loads(file.read_text(encoding='utf-8'))
    texts = [''.join(cell['source']) for cell in made['cells']]
    assert not any(word in text for text in texts for word in ('**Answer', '**Seen.**', 'assert '))
    assert not any(cell.get('outputs') for cell in made['cells'])
    for number in EXERCISES:
        place = next(n for n, text in enumerate(texts) if text.startswith(f'**Exercise {number}.**'))
        assert texts[place + 1] == '# your answer\n'
    assert texts.count('**What do you see?** Which numbers show it, and why is it so?') == len(SECTIONS)
    assert len({cell['id'] for cell in made['cells']}) == len(made['cells'])
    nbformat = pytest.importorskip('nbformat')
    nbformat.validate(nbformat.from_dict(made))
