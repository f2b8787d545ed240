"""Files of trajectories: the forms that are published, and what is refused, with its place."""

import json

import pytest
from helpers.timed_figures import Moves, points_of, table, timed

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.trajectory import plan_trajectory
from mobile_robot_control.reference.trajectory_files import read_trajectory, table_of_trajectory

TIMES = [0.1 * n for n in range(21)]
WAY = [(round(0.25 * time * time, 6), 0.5) for time in TIMES]
"""Accelerates along x from rest."""


def wpilib():
    return json.dumps([{
        'time': time, 'velocity': 0.5 * time, 'acceleration': 0.5, 'curvature': 0.0,
        'pose': {'translation': {'x': x, 'y': y}, 'rotation': {'radians': 0.0}}}
        for time, (x, y) in zip(TIMES, WAY, strict=True)])


def choreo(**more):
    return json.dumps({'name': 'New', 'version': 1, 'snapshot': {'waypoints': [{'x': 0.0, 'y': 0.5}]}, 'trajectory': {
        'sampleType': 'DifferentialDrive', 'waypoints': [0.0, 2.0], 'samples': [
            {'t': time, 'x': x, 'y': y, 'heading': 0.0, 'vl': 0.5 * time, 'vr': 0.5 * time, 'al': 0.5, 'ar': 0.5,
             'fl': 1.0, 'fr': 1.0, **more} for time, (x, y) in zip(TIMES, WAY, strict=True)]}})


def rows(header, form):
    return '\n'.join([header, *(form.format(t=time, x=x, y=y, v=0.5 * time) for time, (x, y) in zip(
        TIMES, WAY, strict=True))])


ECHOED = 'header: {frame_id: odom}\nposes:\n' + ''.join(
    f'- header: {{stamp: {{sec: {1790000000 + int(time)}, nanosec: {round(time % 1.0 * 1e9)}}}}}\n'
    f'  pose: {{position: {{x: {x}, y: {y}}}, orientation: {{x: 0.0, y: 0.0, z: 0.0, w: 1.0}}}}\n'
    for time, (x, y) in zip(TIMES, WAY, strict=True))
FORMS = {
    'table.csv': rows('t,x,y', '{t},{x},{y}'),
    'everything.csv': rows('time [s];x [m];y [m];heading;v;omega;a', '{t};{x};{y};0.0;{v};0.0;0.5'),
    'list.yaml': rows('waypoints:', '- {{t: {t}, x: {x}, y: {y}, heading: 0.0}}'),
    'echoed.yaml': ECHOED, 'wpilib.json': wpilib(), 'choreo.traj': choreo(),
}


@pytest.mark.parametrize('name', FORMS)
def test_each_published_form_gives_the_same_motion(tmp_path, name):
    file = tmp_path / name
    file.write_text(FORMS[name])
    points = read_trajectory(file)
    assert points.points == tuple(WAY)
    assert points.times == pytest.approx(TIMES)
    assert points.headings in ((), (0.0,) * 21)
    motion = plan_trajectory(timed(points))
    assert motion.period == pytest.approx(2.0)
    assert motion.reference(1.0).velocity == pytest.approx((0.5, 0.0), abs=0.01)


@pytest.mark.parametrize(('name', 'text', 'words'), [
    ('swerve.traj', choreo(vx=1.0, vy=0.0), r'is of a swerve drive \(vx, vy\), which moves sideways'),
    ('old.traj', json.dumps({'samples': [{'x': 0.0, 'y': 0.0, 'timestamp': 0.0, 'velocityX': 0.0}]}), 'swerve drive'),
    ('empty.traj', json.dumps({'trajectory': {'samples': []}}), 'has no samples; generate the trajectory in Choreo'),
    ('line.path', json.dumps({'version': '2025.0', 'waypoints': [{'anchor': {'x': 0, 'y': 0}, 'nextControl': None}]}),
     "is a path of PathPlanner, which has no times: .* or give its positions as a table to curve = 'path'"),
    ('map.geojson', json.dumps({'type': 'FeatureCollection'}), 'holds no states with times'),
    ('cut.json', '[{"time": 0.0', r'is no JSON \('),
    ('plain.csv', '0,0\n1,0\n2,0\n3,0\n', r"plain\.csv:1: has no time; write t,x,y .*, or drive it as curve = 'path'"),
    ('twice.csv', 't,x,y\n0,0,0\n1,1,0\n1,2,0\n', r'twice\.csv:4: t = 1 s does not follow 1 s; leave it out'),
    ('text.csv', 't,x,y\n0,0,0\nsoon,1,0\n', r'text\.csv:3: time = soon is no number'),
    ('ms.csv', 't_ms,x,y\n0,0,0\n', r"'t_ms' has the unit ms; convert it to s, and name it t \[s\]"),
    ('side.csv', 't,x,y,vx,vy\n0,0,0,0,0\n', "'vy' is of a robot that moves sideways, and one with two wheels"),
    ('few.csv', 't,x,y\n0,0,0\n1,1,0\n', r'has 2 points with times; a trajectory needs 4 or more'),
    ('gaps.csv', 't,x,y,heading\n0,0,0,0\n1,1,0,\n2,2,0,0\n3,3,0,0\n', '1 points lack the heading that others have'),
    ('inf.csv', 't,x,y\n0,0,0\n1,inf,0\n', r'inf\.csv:3: x = inf is not finite'),
])
def test_what_is_no_trajectory_of_two_wheels_is_refused_with_the_place_and_the_remedy(tmp_path, name, text, words):
    file = tmp_path / name
    file.write_text(text)
    with pytest.raises(ParameterError, match=words):
        read_trajectory(file)


def test_a_stored_copy_has_the_same_numbers(tmp_path):
    points = points_of(Moves(), 5, True)
    file = tmp_path / 'copy.csv'
    file.write_text(table_of_trajectory(points))
    assert read_trajectory(file)._replace(places=()) == points._replace(places=())
    file.write_text(table(points))
    assert read_trajectory(file).points == points.points
