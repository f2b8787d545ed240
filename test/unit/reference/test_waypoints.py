"""Files of waypoints: CSV and YAML, and every fault named with its line."""

import math

import pytest
from each import each_row

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.waypoints import read_waypoints

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0))


def _read(folder, text, name='path.csv'):
    file = folder / name
    file.write_text(text)
    return read_waypoints(file)


@each_row(('name', 'text'), [
    ('a.csv', '0,0\n2,0\n2,1\n'), ('b.csv', 'x,y\n0,0\n2,0\n2,1\n'),
    ('c.csv', '# mine\n\nx, y, speed\n0, 0,\n2,0,\n2;1 # end\n'),
    ('d.txt', '\ufeff0.0,0e0\r\n2,0\r\n2,1'), ('e.yaml', '- [0, 0]\n- [2, 0]\n- {x: 2, y: 1.0}\n'),
    ('f.yml', 'waypoints:\n  - [0, 0]\n  - [2.0, 0]\n  - [2, 1]\n'),
])
def test_a_file_is_read_with_and_without_header_and_comments(tmp_path, name, text):
    found = _read(tmp_path, text, name)
    assert found.points == SQUARE
    assert found.speeds == (math.inf,) * 3


def test_a_speed_holds_until_another_one(tmp_path):
    assert _read(tmp_path, '0,0\n1,0,0.3\n2,0\n3,0,0.5\n').speeds == (math.inf, 0.3, 0.3, 0.5)


@each_row(('name', 'text', 'words'), [
    ('a.csv', '0,0\n', 'a.csv: has 1 waypoint; a path needs two or more'),
    ('b.csv', '', 'b.csv: has 0 waypoints'),
    ('c.csv', 'x,y\n0,0\n1,0\n1,0\n', 'c.csv:4: (1, 0) is the waypoint before it; leave it out'),
    ('d.csv', '0,0\nnan,1\n', "d.csv:2: 'nan,1' is not finite; write numbers"),
    ('e.csv', '0,0\n1,one\n', "e.csv:2: '1,one' is no x,y or x,y,speed in numbers"),
    ('f.csv', '0,0\n1\n', "f.csv:2: '1' has 1 fields; write x,y or x,y,speed"),
    ('g.csv', '0,0\n1,2,3,4\n', 'g.csv:2: '), ('h.csv', '0,0\n1,0,0\n', 'h.csv:2: speed = 0 m/s; write more than 0'),
    ('i.csv', '0,0\n1e15,0\n', 'i.csv:2: '), ('j.yaml', 'a: [', 'j.yaml:1: is no YAML'),
    ('k.yaml', 'points: 3\n', 'k.yaml: holds no list of waypoints'), ('l.yaml', '- [0, 0]\n- 3\n', 'l.yaml:2: '),
    ('m.yaml', '- [0, 0]\n- {x: 1, z: 2}\n', 'm.yaml:2: '),
])
def test_what_is_no_path_is_refused_by_file_and_line(tmp_path, name, text, words):
    with pytest.raises(ParameterError) as refusal:
        _read(tmp_path, text, name)
    assert words in str(refusal.value)


@each_row(('name', 'rows', 'first', 'more'), [
    ('a.csv', [f'{n},0,1,2,{n}' for n in range(30)], "a.csv:1: '0,0,1,2,0' has 5 fields; write x,y or x,y,speed", 29),
    ('b.csv', [*(f'{n},0' for n in range(20)), *(f'{n},w{n}' for n in range(12))], "b.csv:21: '0,w0' is no x,y", 11),
    ('c.csv', [f'{n // 2},0' for n in range(40)], 'c.csv:2: (0, 0) is the waypoint before it', 19),
    ('d.csv', [f'{n},0,-{n + 1}' for n in range(30)], 'd.csv:1: speed = -1 m/s; write more than 0', 29),
    ('e.yaml', [f'- {{a: {n}}}' for n in range(30)], 'e.yaml:1: is no [x, y], [x, y, speed] or {x: ..., y: ', 29),
])
def test_a_fault_of_many_rows_is_told_once(tmp_path, name, rows, first, more):
    with pytest.raises(ParameterError) as refusal:
        _read(tmp_path, '\n'.join(rows) + '\n', name)
    violation, = refusal.value.violations
    assert first in violation
    assert violation.endswith(f'(and {more} more of this kind)')
    assert "''" not in violation


def test_a_file_that_is_none_is_named(tmp_path):
    for file in (tmp_path, tmp_path / 'nothing.csv'):
        with pytest.raises(ParameterError, match='cannot be read'):
            read_waypoints(file)
