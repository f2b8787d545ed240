"""Draw the folders of the package with their imports, from the code, as the picture of docs/architecture.md."""

import ast
from collections.abc import Iterator
from graphlib import TopologicalSorter
from html import escape
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / 'mobile_robot_control'
PICTURE = ROOT / 'docs' / 'images' / 'packages.svg'
_WIDTH, _HEIGHT, _LINE, _ACROSS, _DOWN, _MARGIN = 118, 30, 8, 18, 40, 16
_BESIDE = 'quantities, topics, jit, version'
_OUTSIDE = ('__init__.py', 'testing.py')
"""The package's face, and modules for users alone: nothing of the package imports them."""
_SWEEPS = 12
_STYLE = """
svg{color-scheme:light dark;font:13px system-ui,"DejaVu Sans",sans-serif}
.box{fill:#eef3f8;stroke:#5b7690}.name{fill:#1a2733}.edge{stroke:#8497a8;fill:none}
@media(prefers-color-scheme:dark){.box{fill:#1f2b36;stroke:#7f9bb5}.name{fill:#e3ebf2}.edge{stroke:#6c8093}}
"""


def imported_names(path: Path) -> Iterator[str]:
    """Yield the dotted names that a file imports, wherever in the file it does."""
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.ImportFrom):
            yield from (f'{node.module}.{alias.name}' for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def imports_between_folders() -> dict[str, set[str]]:
    """Return, for each folder and each module beside them, those that it imports from."""
    files = [path for path in sorted(PACKAGE.rglob('*.py')) if path.relative_to(PACKAGE).parts[0] not in _OUTSIDE]
    graph: dict[str, set[str]] = {_folder(path): set() for path in files}
    for path in files:
        parts = [name.split('.') for name in imported_names(path)]
        graph[_folder(path)] |= {part[1] if part[1] in graph else _BESIDE for part in parts
                                 if part[0] == PACKAGE.name and part[1] != '__version__'}
    return {folder: used - {folder} for folder, used in graph.items()}


def _folder(path: Path) -> str:
    """Return the folder of a file; the modules beside the folders are one."""
    first = path.relative_to(PACKAGE).parts[0]
    return _BESIDE if first.removesuffix('.py') in _BESIDE.split(', ') else first.removesuffix('.py')


def _direct(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """Return the graph without the imports that follow from others."""
    below: dict[str, set[str]] = {}
    for folder in TopologicalSorter(graph).static_order():
        below[folder] = graph[folder].union(*(below[used] for used in graph[folder]))
    return {folder: {one for one in used if not any(one in below[other] for other in used)}
            for folder, used in graph.items()}


def _rows(graph: dict[str, set[str]]) -> tuple[list[list[str]], dict[str, list[str]]]:
    """
    Return the rows from the top, each folder right below those that use it, and the way of each line.

    A line over several rows has a place in each of them, so that it runs beside the boxes there.
    """
    users = {folder: {user for user, used in graph.items() if folder in used} for folder in graph}
    level: dict[str, int] = {}
    for folder in TopologicalSorter(users).static_order():
        level[folder] = 1 + max((level[user] for user in users[folder]), default=-1)
    rows: list[list[str]] = [[] for _ in range(max(level.values()) + 1)]
    for folder in sorted(level):
        rows[level[folder]].append(folder)
    ways: dict[str, list[str]] = {}
    for folder, used in sorted(graph.items()):
        for one in sorted(used):
            between = [f'{folder}>{one}:{n}' for n in range(level[folder] + 1, level[one])]
            for name in between:
                rows[int(name.rpartition(':')[2])].append(name)
            ways[f'{folder}>{one}'] = [folder, *between, one]
    near: dict[str, list[str]] = {name: [] for row in rows for name in row}
    for way in ways.values():
        for upper, lower in pairwise(way):
            near[upper].append(lower)
            near[lower].append(upper)
    for _ in range(_SWEEPS):
        place = _across(rows)
        for row in rows:
            row.sort(key=lambda name: (sum(place[one] for one in near[name]) / max(1, len(near[name])), name))
            place = _across(rows)
    return rows, ways


def _width(name: str) -> float:
    return _LINE if '>' in name else _WIDTH if name != _BESIDE else 2.6 * _WIDTH


def _across(rows: list[list[str]]) -> dict[str, float]:
    """Return the middle of each box and of each line's place, in rows around 0."""
    place = {}
    for row in rows:
        x = -0.5 * (sum(map(_width, row)) + _ACROSS * (len(row) - 1))
        for name in row:
            place[name] = x + 0.5 * _width(name)
            x += _width(name) + _ACROSS
    return place


def drawing() -> str:
    """Return the picture as SVG."""
    graph = imports_between_folders()
    rows, ways = _rows(_direct(graph))
    across = _across(rows)
    left = min(x - 0.5 * _width(name) for name, x in across.items()) - _MARGIN
    width = -2 * left
    height = 2 * _MARGIN + len(rows) * (_HEIGHT + _DOWN) - _DOWN
    top = {name: _MARGIN + n * (_HEIGHT + _DOWN) for n, row in enumerate(rows) for name in row}
    edges = []
    for way in ways.values():
        path = f'M{across[way[0]] - left:g} {top[way[0]] + _HEIGHT:g}'
        for upper, lower in pairwise(way):
            x, y, u, v = across[upper] - left, top[upper] + _HEIGHT, across[lower] - left, top[lower]
            path += f'C{x:g} {y + 22:g} {u:g} {v - 22:g} {u:g} {v:g}' + (f'V{v + _HEIGHT:g}' if '>' in lower else '')
        edges.append(f'<path class="edge" d="{path}"/>')
    boxes = [f'<rect class="box" x="{x - left - 0.5 * _width(name):g}" y="{top[name]:g}" width="{_width(name):g}" '
             f'height="{_HEIGHT}" rx="5"/><text class="name" x="{x - left:g}" y="{top[name] + 20:g}" '
             f'text-anchor="middle">{escape(name)}</text>' for name, x in across.items() if '>' not in name]
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" role="img" '
            'aria-label="The folders of the package; each imports from those below it that a line leads to">\n'
            f'<style>{_STYLE}</style>\n' + '\n'.join([*edges, *boxes]) + '\n</svg>\n')


if __name__ == '__main__':
    PICTURE.write_text(drawing(), encoding='utf-8')
