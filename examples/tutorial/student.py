"""
Write the notebook of this folder for students: without answers, claims and outputs, with room for their own.

``python examples/tutorial/student.py FILE.ipynb``
"""

import json
import sys
from pathlib import Path

NOTEBOOK = Path(__file__).with_name('trajectory_tracking.ipynb')
_QUESTION = '**What do you see?** Which numbers show it, and why is it so?'


def _cell(kind: str, name: str, text: str) -> dict[str, object]:
    """Return a cell of a notebook."""
    cell: dict[str, object] = {'cell_type': kind, 'id': name, 'metadata': {}, 'source': text}
    return cell | ({'outputs': [], 'execution_count': None} if kind == 'code' else {})


def for_students(notebook: dict[str, object]) -> dict[str, object]:
    """Return the notebook without what students shall find themselves."""
    cells: list[dict[str, object]] = []
    for cell in notebook['cells']:  # type: ignore[attr-defined]
        kind, name, text = cell['cell_type'], cell['id'], ''.join(cell['source'])
        if text.startswith('# Answers'):
            break
        if 'assert ' in text and kind == 'code':
            continue
        cells.append(_cell(kind, name, _QUESTION if text.startswith('**Seen.**') else text))
        if text.startswith(('**Seen.**', '**Exercise ')):
            cells.append(_cell('code', f'{name}-answer', '# your answer\n'))
    return notebook | {'cells': cells}


def main(arguments: list[str]) -> int:
    """Write the file that the only argument names; return an exit code."""
    if len(arguments) != 1 or Path(arguments[0]).exists():
        print('student: name a file that does not exist yet, such as student.ipynb', file=sys.stderr)
        return 2
    made = for_students(json.loads(NOTEBOOK.read_text(encoding='utf-8')))
    Path(arguments[0]).write_text(json.dumps(made, indent=1, ensure_ascii=False) + '\n', encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
