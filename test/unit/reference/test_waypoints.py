"""Files of waypoints: CSV, YAML and bags, and every fault named with its line."""

import json
import math
import random
import re

import pytest
from helpers.bag_making import record
from rclpy.serialization import serialize_message

from mobile_robot_control import plan
from mobile_robot_control.messages.writing import path_message
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.path_parameters import PathParameters
from mobile_robot_control.reference.trajectory_parameters import TrajectoryParameters
from mobile_robot_control.reference.waypoint_files import read_waypoints
from mobile_robot_control.reference.waypoints import table_of
from mobile_robot_control.runs import command as simulation
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import at_cart_start, configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.recorded_path import trajectory_in, waypoints_in

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0))


def _read(folder, text, name='path.csv'):
    file = folder / name
    file.write_text(text)
    return read_waypoints(file)


@pytest.mark.parametrize(('name', 'text'), [
    ('a.csv', '0,0\n2,0\n2,1\n'), ('b.csv', 'x,y\n0,0\n2,0\n2,1\n'),
    ('c.csv', '# mine\n\nx [m], y [m], speed\n0, 0,\n2,0,\n2;1 # end\n'),
    ('d.txt', '\ufeff0.0,0e0\r\n2,0\r\n2,1'), ('e.yaml', '- [0, 0]\n- [2, 0]\n- {x: 2, y: 1.0}\n'),
    ('f.yml', 'waypoints:\n  - [0, 0]\n  - [2.0, 0]\n  - [2, 1]\n'), ('g.csv', 'y,x\n0,0\n0,2\n1,2\n'),
    ('h.csv', '# s_m; x_m; y_m; psi_rad\n0; 0; 0; 0.1\n2; 2; 0; 0\n3; 2; 1; 0\n'),
    ('i.tsv', 'x\ty\n0\t0\n2\t0\n2\t1\n'), ('j.txt', '0 0\n 2  0\n2 1\n'),
    ('k.yaml', 'a: {x: 0, y: 0, yaw: 1}\nb: {x: 2, y: 0, yaw: 1}\nc: {x: 2, y: 1, yaw: 1}\n'),
    ('n.yaml', 'waypoints:\n  a: {x: 0, y: 0, yaw: 1}\n  b: [2, 0]\n  c: {position: {x: 2, y: 1}}\n'),
    ('o.csv', '"x (m)","y (m)"\n"0","0"\n2,0\n2,1\n'), ('p.txt', 'x [m] y [m]\n0 0\n2 0\n2 1\n'),
    ('q.csv', 'yaw_rad,x_m,y\n0,0,0\n0,2,0\n,2,1\n'), ('r.csv', 'x,y\n[m],[m]\n0,0\n2,0\n2,1\n'),
    ('l.yaml', 'waypoints:\n- pose: {position: {x: 0, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}\n'
               '- position: [2, 0, 0]\n- {position: {x: 2, y: 1}}\n'),
    ('m.yaml', 'header: {stamp: {sec: 1, nanosec: 0}, frame_id: ""}\nposes:\n'
               + ''.join(f'- header: {{frame_id: ""}}\n  pose: {{position: {{x: {x}, y: {y}, z: 0.0}}}}\n'
                         for x, y in ((0, 0), (2, 0), (2, 1))) + '---\n'),
])
def test_a_file_is_read_by_the_names_of_its_columns(tmp_path, name, text):
    found = _read(tmp_path, text, name)
    assert found.points == SQUARE
    assert found.speeds == (math.inf,) * 3


def test_a_speed_holds_until_another_one_and_repeated_points_are_counted(tmp_path):
    assert _read(tmp_path, 'x,y,vx_mps\n0,0\n1,0,0.3\n2,0\n3,0,0.5\n').speeds == (math.inf, 0.3, 0.3, 0.5)
    repeated = _read(tmp_path, 'x,y,heading\n0,0,0\n0,0,0\n1,0,0\n1,0,0.05\n1,0,0\n2,0,0\n')
    assert (repeated.points, repeated.repeated) == (((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)), 3)


def test_headings_of_several_turns_stay_radians_where_they_fit_the_path_or_degrees_do_not(tmp_path):
    lap = [(math.cos(0.1 * n), math.sin(0.1 * n), 0.1 * n + math.pi / 2.0) for n in range(200)]
    for rows in (lap, [(n, 0, 1.5 * n) for n in range(40)]):
        text = 'x,y,heading\n' + ''.join(f'{x},{y},{heading}\n' for x, y, heading in rows)
        assert _read(tmp_path, text).headings == tuple(heading for *_, heading in rows)


def test_what_a_file_says_and_is_not_used_is_told(tmp_path, capsys):
    limits = {f'reference_cart.timing.{name}': 0.5 for name in ('max_linear_velocity', 'max_linear_acceleration')}
    (tmp_path / 'p.csv').write_text('# x_m, y_m, w_tr_right_m, w_tr_left_m, time, stamp [ns]\n'
                                    '0,0,1,1,5,7\n1,0,1,1,15,7\n2,0,1,1,35,7\n')
    name = f'{tmp_path}/p.csv'
    planned = plan(name, parameters=limits)
    assert planned.ignored == (
        f'{name}: the column w_tr_right_m is not used', f'{name}: the column w_tr_left_m is not used',
        f'{name}: the column stamp [ns] is not used',
        f'{name}:2: the times of the waypoints span 30 s, and are not used: the path is driven in 5 s')
    values = limits | {'reference_cart.curve': 'path', 'reference_cart.path.file': name}
    assert simulation.main(['--duration', '0.1', *(part for key, value in values.items()
                                                   for part in ('-p', f'{key}:={value}'))]) == 0
    assert capsys.readouterr().err.splitlines()[-4:] == list(planned.ignored)


def test_a_frame_that_a_file_names_must_be_that_of_odometry(tmp_path):
    (tmp_path / 'p.yaml').write_text('header: {frame_id: map}\nposes: [{pose: {position: {x: 0, y: 0}}}, '
                                     '{pose: {position: {x: 1, y: 0}}}]\n')
    with pytest.raises(ParameterError, match="is in the frame 'map', and path_frame is 'odom'"):
        plan(tmp_path / 'p.yaml', parameters={'reference_cart.timing.max_linear_velocity': 0.5,
                                              'reference_cart.timing.max_linear_acceleration': 0.5})


@pytest.mark.parametrize(('name', 'text', 'words'), [
    ('a.csv', '0,0\n', 'a.csv: has 1 waypoint; a path needs two or more'),
    ('b.csv', '', 'b.csv: has 0 waypoints'),
    ('c.csv', 'x,y,direction\n0,0,1\n1,0,up\n', 'c.csv:3: direction = up; write 1 or -1'),
    ('d.csv', '0,0\nnan,1\n', "d.csv:2: 'nan,1' is not finite; write numbers"),
    ('e.csv', '0,0\n1,one\n', "e.csv:2: '1,one' is no x,y in numbers"),
    ('f.csv', '0,0\n1\n', "f.csv:2: '1' has 1 fields; write x,y"),
    ('g.csv', '0,0,1\n1,2,3\n', "g.csv:1: '0,0,1' has 3 fields; write x,y; or x,y,speed with these names above"),
    ('h.csv', 'x,y,speed\n0,0\n1,0,0\n', 'h.csv:3: speed = 0 m/s; write more than 0'),
    ('i.csv', '0,0\n1e15,0\n', 'i.csv:2: '), ('j.yaml', 'a: [', 'j.yaml:1: is no YAML'),
    ('k.yaml', 'points: 3\n', 'k.yaml: holds no list of waypoints'), ('l.yaml', '- [0, 0]\n- 3\n', 'l.yaml:2: '),
    ('m.yaml', '- [0, 0]\n- {x: 1, z: 2}\n', "m.yaml:2: the key 'z' is not understood"),
    ('n.csv', 'x,y,z\n0,0,1\n', "n.csv:1: the column 'z' is not understood"),
    ('o.csv', 'lat,lon\n52,4\n', 'o.csv:1: lat,lon are geographic coordinates'),
    ('p.csv', 'x,speed\n0,0\n', 'p.csv:1: no column is named y'),
    ('q.csv', 'x,y,x\n0,0\n', 'q.csv:1: 2 columns are named x'),
    ('r.yaml', '- [0, 0]\n- [1, 2, 3]\n', "r.yaml:2: '1,2,3' has 3 fields"),
    ('t.csv', 'x [mm],y [mm]\n0,0\n', "t.csv:1: the column 'x [mm]' has the unit mm; convert it to m, and name it"),
    ('u.csv', '# y, x, heading_deg\n0,0,0\n', "u.csv:1: the column 'heading_deg' has the unit deg; convert it to rad"),
    ('v.csv', 'x y speed (km/h)\n0 0 1\n', "v.csv:1: the column 'speed (km/h)' has the unit km/h; convert it to m/s"),
    ('w.csv', 'x,y\n[ft],[ft]\n0,0\n', "w.csv:2: the column 'x [ft]' has the unit ft; convert it to m"),
    ('x.yaml', '- {x_cm: 0, y_cm: 0}\n- {x_cm: 9, y_cm: 0}\n', "x.yaml:1: the key 'x_cm' has the unit cm; convert"),
    ('y.csv', 'x,y,speed\n0,0,-0.3\n', 'speed = -0.3 m/s; write more than 0, and for backwards a column direction'),
    ('z.csv', 'x,y,yaw\n0,0,90\n0,1,90\n0,2,90\n-1,2,180\n', 'z.csv:2: heading = 90 exceeds 2π, and the headings are'),
    ('z.json', '{"type": "FeatureCollection", "features": []}', 'z.json: is JSON, as GeoJSON and the paths of'),
    ('z.gpx', '<?xml version="1.0"?>\n<gpx/>', 'z.gpx: is XML, as GPX and KML are; convert its positions to a table'),
    ('s.yaml', '- [0, 0]\n- [1, 0]\n---\n- [0, 0]\n', 's.yaml:4: holds 2 paths; keep one'),
])
def test_what_is_no_path_is_refused_by_file_and_line(tmp_path, name, text, words):
    with pytest.raises(ParameterError) as refusal:
        _read(tmp_path, text, name)
    assert words in str(refusal.value)


@pytest.mark.parametrize(('name', 'rows', 'first', 'more'), [
    ('a.csv', [f'{n},0,1,2,{n}' for n in range(30)], "a.csv:1: '0,0,1,2,0' has 5 fields; write x,y", 29),
    ('b.csv', [*(f'{n},0' for n in range(20)), *(f'{n},w{n}' for n in range(12))], "b.csv:21: '0,w0' is no x,y", 11),
    ('d.csv', ['x,y,speed', *(f'{n},0,-{n + 1}' for n in range(30))], 'd.csv:2: speed = -1 m/s; write more than 0', 29),
    ('e.yaml', [f'- {{x: {n}}}' for n in range(30)], 'e.yaml:1: is no [x, y], {x: ..., y: ', 29),
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


def test_a_bag_gives_the_first_path_of_a_planner_or_the_poses_of_odometry(tmp_path):
    made = configure(load([], ['reference_cart.curve:=circle']))
    bag = record(tmp_path / 'bag', rollout(at_cart_start(made), 2.0))
    with pytest.raises(ParameterError, match=r'holds paths or odometry on /odom, /reference; name one topic'):
        waypoints_in(PathParameters(str(bag)))
    with pytest.raises(ParameterError, match='holds no path and no odometry /plan; name'):
        waypoints_in(PathParameters(str(bag), 'plan'))
    driven = waypoints_in(PathParameters(str(bag), 'reference'))
    assert driven.frame == 'odom'
    assert len(driven.points) == 201
    assert [math.hypot(x, y) for x, y in driven.points] == pytest.approx([1.0] * 201)
    assert driven.headings[0] == pytest.approx(math.pi / 2.0)
    timed = trajectory_in(TrajectoryParameters(str(bag), 'reference'))
    assert (timed.points, timed.headings, timed.frame) == (driven.points, driven.headings, 'odom')
    assert (timed.times, timed.signs) == (tuple(n / 100 for n in range(201)), (1,) * 201)
    limits = {'max_linear_velocity': 0.5, 'max_linear_acceleration': 0.5}
    planned = plan(bag, parameters={'reference_cart.path.topic': '/reference', **{
        f'reference_cart.timing.{name}': value for name, value in limits.items()}})
    assert planned.length == pytest.approx(2.0 * math.pi * 2.0 / 16.0, rel=5e-3)
    # what an experiment keeps beside its parameters
    (tmp_path / 'kept.csv').write_text(table_of(driven))
    kept = read_waypoints(tmp_path / 'kept.csv')
    assert (kept.points, kept.headings) == (driven.points, driven.headings)
    with BagWriter(tmp_path / 'plans') as writer:
        for length in (3, 2):
            message = path_message('map', [Pose(float(n), 0.0, 0.5) for n in range(length)])
            writer.write('/plan', 'nav_msgs/msg/Path', 10**18, serialize_message(message))
    planner = waypoints_in(PathParameters(str(tmp_path / 'plans')))
    assert (planner.points, planner.frame) == (((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)), 'map')
    assert planner.headings == pytest.approx((0.5,) * 3)
    # whose poses have no stamps
    with pytest.raises(ParameterError, match=r'/plan 1: t = 0 s does not follow 0 s'):
        trajectory_in(TrajectoryParameters(str(tmp_path / 'plans')))


_NAMES = {'x': ['x', 'X', 'x_m', 'x [m]', 'x(m)', '"x"', 'x [mm]', 'x_cm', 'x (ft)', 'X [km]'],
          'y': ['y', 'Y', 'y_m', 'y [m]', ' y ', "'y'", 'y [in]', 'y_mm'],
          'speed': ['speed', 'velocity', 'vx_mps', 'speed [m/s]', 'Speed (mps)', 'speed [km/h]', 'speed_mph'],
          'heading': ['heading', 'yaw', 'psi_rad', 'theta [rad]', 'heading (deg)', 'yaw_deg', 'theta [°]'],
          '': ['s_m', 'kappa_radpm', 'time', 'stamp [ns]', 'w_tr_right_m'], 'z': ['z', 'w', 'qz', 'name']}
_FOREIGN_UNIT = re.compile(r'mm|cm|ft|km|\[in|mph|deg|°')
_TRUTH = {'x': (0.0, 2.0, 2.0), 'y': (0.0, 0.0, 1.0), 'speed': (0.5, 0.4, 0.3), 'heading': (0.0, 0.5, 1.5)}


def test_a_drawn_header_gives_a_right_path_or_names_the_column_and_the_remedy(tmp_path):
    rng = random.Random(69)  # noqa: S311 (a draw that can be repeated)
    read = refused = 0
    for _ in range(200):
        meanings = ['x', 'y', *rng.sample(['speed', 'heading', '', 'z'], rng.choice((0, 0, 1, 1, 2, 3)))]
        rng.shuffle(meanings)
        names = [rng.choice(_NAMES[meaning]) if meaning in 'xy' or rng.random() < 0.8 else _NAMES[meaning][0]
                 for meaning in meanings]
        separator = rng.choice([',', ';', '\t', ' ', ', ']) if not any(' y' in name for name in names) else ','
        rows = [[repr(_TRUTH.get(meaning, (7.0, 7.0, 7.0))[n]) for meaning in meanings] for n in range(3)]
        if rng.random() < 0.5:
            text = rng.choice(['', '# ', '#']) + '\n'.join(separator.join(line) for line in (names, *rows))
        else:
            text = '\n'.join('- {' + ', '.join(f'{json.dumps(name)}: {value}' for name, value in zip(
                (name.strip('"\'') for name in names), row, strict=True)) + '}' for row in rows)
        wrong = [name.strip('"\' ') for meaning, name in zip(meanings, names, strict=True)
                 if meaning == 'z' or _FOREIGN_UNIT.search(name)]
        name = 'p.yaml' if text.startswith('-') else 'p.csv'
        if wrong:
            refused += 1
            with pytest.raises(ParameterError, match=r'convert it to .*, and name it|leave it out, or name it') as no:
                _read(tmp_path, text, name)
            assert any(f"'{one}'" in str(no.value) for one in wrong), text
            continue
        read += 1
        found = _read(tmp_path, text, name)
        assert found.points == SQUARE
        for meaning, values in (('speed', found.speeds), ('heading', found.headings)):
            assert meaning not in meanings or values == _TRUTH[meaning], text
    assert min(read, refused) > 40
