"""Drives of bags with plans, as of another stack: goals, frames, and what is refused."""

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import mobile_robot_control as mrc
from mobile_robot_control.parameters.declaration import ParameterError

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPE = STORE.types
START = 1_700_000_000


def header(time, frame):
    """A header of wall time."""
    seconds, nanoseconds = divmod(round(time * 1e9), 10**9)
    return TYPE['std_msgs/msg/Header'](TYPE['builtin_interfaces/msg/Time'](START + seconds, nanoseconds), frame)


def pose(x, y, heading):
    """A planar pose."""
    return TYPE['geometry_msgs/msg/Pose'](
        TYPE['geometry_msgs/msg/Point'](x, y, 0.0),
        TYPE['geometry_msgs/msg/Quaternion'](0.0, 0.0, np.sin(0.5 * heading), np.cos(0.5 * heading)))


def odometry(time, x, y, heading, v):
    """A message of odometry."""
    vector = TYPE['geometry_msgs/msg/Vector3']
    twist = TYPE['geometry_msgs/msg/Twist'](vector(v, 0.0, 0.0), vector(0.0, 0.0, 0.0))
    return TYPE['nav_msgs/msg/Odometry'](
        header(time, 'odom'), 'base_link', TYPE['geometry_msgs/msg/PoseWithCovariance'](
            pose(x, y, heading), np.zeros(36)), TYPE['geometry_msgs/msg/TwistWithCovariance'](twist, np.zeros(36)))


def plan(time, points, frame='map'):
    """A plan of a planner, whose poses have no orientation but the last."""
    stamped = TYPE['geometry_msgs/msg/PoseStamped']
    poses = [stamped(header(time, frame), pose(x, y, 0.0)) for x, y in points]
    return TYPE['nav_msgs/msg/Path'](header(time, frame), poses)


def correction(time, x, y, heading):
    """The transform of a localisation."""
    at = pose(x, y, heading)
    return TYPE['tf2_msgs/msg/TFMessage']([TYPE['geometry_msgs/msg/TransformStamped'](
        header(time, 'map'), 'odom', TYPE['geometry_msgs/msg/Transform'](
            TYPE['geometry_msgs/msg/Vector3'](x, y, 0.0), at.orientation))])


KINDS = {'/plan': 'nav_msgs/msg/Path', '/odom': 'nav_msgs/msg/Odometry', '/tf': 'tf2_msgs/msg/TFMessage'}


def bag(path, messages):
    """Write a bag of (time, topic, message)."""
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {topic: writer.add_connection(topic, KINDS[topic], typestore=STORE)
                       for topic in dict.fromkeys(topic for _, topic, _ in messages)}
        for time, topic, message in sorted(messages, key=lambda one: one[0]):
            writer.write(connections[topic], round((START + time) * 1e9), STORE.serialize_cdr(message, KINDS[topic]))
    return path


def drive(beside=0.0, seconds=10.0):
    """Odometry straight ahead at 0.2 m/s, in a frame that is turned by a quarter in that of the map."""
    return [(time, '/odom', odometry(time, 0.2 * time, beside, 0.0, 0.2))
            for time in np.arange(0.0, seconds + 0.01, 0.05).tolist()]


TURNED = [(time, '/tf', correction(time, 1.0, 0.0, 0.5 * np.pi)) for time in np.arange(0.0, 10.0, 0.1).tolist()]
UP = [(1.0, 0.0), (1.0, 2.0)]
"""In the map, what is straight ahead in odometry."""


def rows(path, **options):
    """The drives of a bag."""
    return mrc.load(path, **{'by_path': '/plan', **options}).metrics['path']


def test_a_plan_in_the_map_judges_odometry_as_the_localisation_saw_it(tmp_path):
    [row] = rows(bag(tmp_path / 'bag', [(0.0, '/plan', plan(0.0, UP)), *TURNED, *drive(beside=0.03)]))
    assert row['poses'] == 'localisation'
    assert row['rms_cross_track_error'] == pytest.approx(0.03)
    assert row['progress'] == pytest.approx(2.0)
    assert row['end_position_error'] == pytest.approx(0.03)
    # no plan has an orientation, and no parameters the wheel separation
    assert row['end_heading_error'] is row['command_variation'] is None


def test_a_plan_that_ends_elsewhere_begins_another_drive_and_one_to_the_same_end_none(tmp_path):
    again, elsewhere = plan(2.0, [(1.0, 0.4), (1.0, 2.0)]), plan(5.0, [(1.0, 1.0), (1.0, 3.0)])
    path = bag(tmp_path / 'bag', [(0.0, '/plan', plan(0.0, UP)), (2.0, '/plan', again), (5.0, '/plan', elsewhere),
                                  *TURNED, *drive()])
    first, second = rows(path)
    assert [row['drive'].rpartition(' ')[2] for row in (first, second)] == ['1', '2']
    assert (first['progress'], second['progress']) == pytest.approx((1.0, 1.0), abs=0.02)
    assert (first['path_length'], second['path_length']) == pytest.approx((2.0, 2.0))


def test_the_newest_plans_reset_the_error_which_is_told(tmp_path):
    # the robot drives 3 cm beside the first plan, and each newer one begins at it
    plans = [(time, '/plan', plan(time, [(1.0 - 0.03 * bool(time), 0.2 * time), (1.0, 2.0)]))
             for time in (0.0, 4.0, 8.0)]
    path = bag(tmp_path / 'bag', [*plans, *TURNED, *drive(beside=0.03)])
    run = mrc.load(path, by_path='/plan', plan='newest')
    [newest] = run.metrics['path']
    [first] = rows(path)
    assert newest['rms_cross_track_error'] < first['rms_cross_track_error']
    assert any('3 plans in turn: a plan that begins at the robot resets' in problem for problem in run.problems)


@pytest.mark.parametrize(('messages', 'by_path', 'told'), [
    ([(0.0, '/plan', plan(0.0, UP))], '/plan', 'there is no transform from map to odom on /tf, which has nothing'),
    ([(0.0, '/plan', plan(0.0, UP)), *TURNED], '/plan_smoothed', 'topics of type nav_msgs/msg/Path there: /plan'),
    (TURNED, '/plan', 'topics of type nav_msgs/msg/Path there: none'),
    (TURNED, 'reference', 'has no recorded reference'),
    ([(30.0, '/plan', plan(30.0, UP)), *TURNED], '/plan', 'the recording has no motion after its plan'),
])
def test_what_cannot_be_judged_is_refused_by_name(tmp_path, messages, by_path, told):
    with pytest.raises(ParameterError, match=told):
        rows(bag(tmp_path / 'bag', [*messages, *drive()]), by_path=by_path)


def test_a_run_in_time_has_the_cross_track_error_of_its_metrics(tmp_path):
    run = mrc.simulate(duration=16.0, parameters={'plant.initial_pose': [1.0, 0.05, 1.5]})
    run.save(tmp_path / 'run.csv')
    [row] = rows(tmp_path / 'run.csv', by_path='reference')
    for name in ('rms_cross_track_error', 'max_cross_track_error'):
        assert row[name] == pytest.approx(run.metrics[name], abs=2e-4)
    assert row['command_variation'] == pytest.approx(run.metrics['command_variation'], rel=1e-3)


def test_a_file_in_the_frame_of_odometry_judges_without_transforms(tmp_path):
    (tmp_path / 'way.csv').write_text('x,y\n0,0\n2,0\n')
    [row] = rows(bag(tmp_path / 'bag', drive(beside=-0.02)), by_path=tmp_path / 'way.csv')
    assert (row['poses'], row['rms_cross_track_error']) == ('odometry', pytest.approx(0.02))
