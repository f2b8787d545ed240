"""Reports on bags of other robots: plain Twist, other names, odometry and reference at rates of their own."""

import itertools
import random

import pytest
from helpers.bag_making import CMD_VEL, KINDS, ODOM, REFERENCE, WALL, messages_of, record
from helpers.harness import numbers_in
from helpers.measuring import configuration, measured
from helpers.processes import usage_of

from mobile_robot_control.figures.drawing import draw
from mobile_robot_control.messages import writing
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.report import command as report
from mobile_robot_control.report import report_writing
from mobile_robot_control.report.report_writing import timing_table
from mobile_robot_control.runs.bag import choose_topics, missing_topics, read_bag
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.runs.errors import with_errors
from mobile_robot_control.runs.reading import read_run
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES
from mobile_robot_control.runs.samples import collect, samples_of
from mobile_robot_control.topics import LOOP_TOPICS

MS = 1_000_000
PARAMETERS = configuration(position_controller={'controller_type': 'fuzzy'})
DURATION = 4.0
ODOMETRY, TWIST = 'nav_msgs/msg/Odometry', 'geometry_msgs/msg/Twist'
PLAIN = writing.twist_writer('', stamped=False)
NAMES = ['--topic', 'odom:=/base/odom', '--topic', 'cmd_vel:=base/cmd_vel']
BASE = {'odom': '/base/odom', 'cmd_vel': '/base/cmd_vel'}
# without parameters neither the path nor the wheels are known
UNKNOWN = {'initial_wheel_torque', 'peak_wheel_torque', 'peak_wheel_power', 'energy', 'torque_variation',
           'rms_cross_track_error', 'max_cross_track_error', 'command_variation'}


@pytest.fixture(scope='module')
def samples():
    return list(rollout(PARAMETERS, DURATION))


def base(path, samples, start=WALL, reference=True, odom_every=20, lost=0.1, kind=TWIST):
    """
    Write the bag of a base that takes cmd_vel.

    Odometry comes every so many ms with a jitter of 2 ms, a share of it lost, and is received 5 ms late; the reference
    comes every 50 ms, 3 ms later than odometry. Stamps count from a start, which is wall time or not.
    """
    rng = random.Random(1)  # noqa: S311 (no secret)
    curve = PARAMETERS.reference_cart.curve
    with BagWriter(path) as writer:
        for sample in samples:
            now, time = round(sample.time * 1e9), sample.time
            if round(time * 1000) % odom_every == 0 and rng.random() >= lost:
                jitter = rng.randrange(2 * MS)
                writer.write('/base/odom', ODOMETRY, WALL + now + 5 * MS,
                             ODOM(start + now + jitter, sample.tick.pose, sample.tick.velocity))
            if reference and round(time * 1000) % 50 == 0:
                cart = reference_at(CURVES[curve.curve], time + 0.003, curve.placement)
                writer.write('/reference', ODOMETRY, WALL + now + 4 * MS, REFERENCE(start + now + 3 * MS, *cart[:2]))
            if round(time * 1000) % 20 == 0:
                message = PLAIN(0, sample.command) if kind == TWIST else CMD_VEL(start + now, sample.command)
                writer.write('/base/cmd_vel', kind, WALL + now + MS, message)
    return path


def reported(output, *arguments):
    assert report.main([*map(str, arguments), '--output', str(output)]) == 0
    return numbers_in(output / 'report.json'), (output / 'report.html').read_text()


@pytest.mark.parametrize(('start', 'kind'), [
    (WALL, TWIST), (12_000 * MS, 'geometry_msgs/msg/TwistStamped'), (0, TWIST)], ids=['wall', 'simulated', 'zero'])
def test_the_errors_of_odometry_and_reference_alone_are_those_of_the_run(samples, tmp_path, start, kind):
    recording = read_bag(base(tmp_path / 'bag', samples, start, kind=kind), topics=BASE)
    found = list(samples_of(with_errors(recording.series, exact=False)))
    assert len(found) > 150
    by_time = {round(sample.time * 1e3): sample for sample in samples}
    for sample in found[1:]:
        # times count from the first reference, 3 ms after that of the rollout; odometry jitters by 2 ms
        then = by_time[round((sample.time * 1e3 + 2.0) / 20.0) * 20]
        assert abs(sample.tick.error.longitudinal - then.tick.error.longitudinal) < 0.003
        assert abs(sample.tick.error.lateral - then.tick.error.lateral) < 0.003
        assert abs(sample.tick.error.heading - then.tick.error.heading) < 0.01
        assert abs(sample.command.linear - then.command.linear) < 0.15


@pytest.mark.usefixtures('quick')
def test_the_page_of_another_robot_has_its_metrics_and_no_word_of_torques(samples, tmp_path):
    base(tmp_path / 'turtle' / 'bag', samples)
    metrics, page = reported(tmp_path / 'out', tmp_path / 'turtle', *NAMES)
    found, (expected, _) = metrics['turtle'], measured(PARAMETERS, DURATION)
    assert found['error'] == 'measured'
    # at the end the error is beyond the band, of the simulated run too
    assert {name for name, value in found.items() if value is None} == UNKNOWN | {'settling_time'}
    assert expected['settling_time'] is None
    for name in ('rms_position_error', 'max_position_error', 'rms_heading_error', 'measured_rms_position_error'):
        assert found[name] == pytest.approx(expected[name], rel=0.03)
    assert found['duration'] == pytest.approx(DURATION, abs=0.1)
    assert found['problems'] == [
        'the tracking error is computed from odom and reference, which is taken to be on straight lines between its '
        'messages']
    assert 'Measured error (odometry)' in page
    shown = page.partition('<h2>Metrics</h2>')[2].partition('<script>')[0]
    for word in ('torque', 'power', 'energy', 'joint_states'):
        assert word not in shown


@pytest.mark.usefixtures('quick')
def test_bags_of_both_kinds_and_without_a_reference_stand_side_by_side(samples, tmp_path):
    base(tmp_path / 'turtle', samples)
    base(tmp_path / 'lost', samples, reference=False)
    record(tmp_path / 'ours', samples)
    metrics, page = reported(tmp_path / 'out', *(tmp_path / name for name in ('turtle', 'ours', 'lost')), *NAMES)
    assert metrics['ours']['energy'] > 0.0
    assert '--topic odom:=/base/odom: the bag has no /base/odom; /odom is taken' in metrics['ours']['problems']
    # one objective has torques, the other has none: neither is the better one; of one torque there is no ratio
    rows = {row.partition('</td>')[0]: row for row in page.split('<tr><td>')}
    assert '★' not in rows['objective, Eq. (29)']
    assert '★' in rows['position error, RMS']
    assert 'peak torque against the least' not in rows
    assert 'there is no reference, and so no tracking error and no metrics' in page
    assert 'the bag holds no other topic of type nav_msgs/msg/Odometry: record reference as such' in ' '.join(
        metrics['lost']['problems'])


def _frames(runs):
    """Return the axes of all figures of a page over runs."""
    for figure in (*RUN_FIGURES, *report_writing.TIMING_FIGURES):
        made = figure.of_runs(runs)
        yield from draw(made).axes if made else ()


def test_no_frame_is_empty(samples, tmp_path):
    def drawn(name, **options):
        recording = read_bag(base(tmp_path / name, samples, **options), topics=BASE)
        return Run(name, with_errors(recording.series, exact=False), (), {}, None)

    turtle, lost = drawn('turtle'), drawn('lost', reference=False)
    ours = Run('ours', collect(samples), (), {}, None)
    counts = []
    for runs in ([turtle], [lost], [ours], [lost, turtle, ours]):
        frames = list(_frames(runs))
        counts.append(len(frames))
        for axes in frames:
            assert any(line.get_xydata().size for line in axes.lines)
            assert not [text for text in axes.texts if text.get_text() == 'not recorded']
    # path, position 2, heading, errors 3, distance, velocity 2, intervals, latency; torque 2, power 2, energy
    assert counts == [12, 8, 15, 17]
    assert 'joint_states' not in timing_table(turtle.series)


@pytest.mark.parametrize(('given', 'expected'), [
    (['odometry:=/odom'], "'odometry' is no topic of the loop; take one of joint_states"),
    (['odom'], 'write NAME:=TOPIC'),
    (['odom:=/base odom'], 'is no name of a topic'),
    (['odom:='], 'is no name of a topic'),
    (['odom:=/a', 'odom:=/b'], 'odom is /a already'),
    (['odom:=/a', 'reference:=/a'], '/a is taken already'),
])
def test_a_topic_that_cannot_be_is_refused_with_the_remedy(tmp_path, capsys, given, expected):
    words = [word for text in given for word in ('--topic', text)]
    try:
        code = report.main([str(tmp_path), '--output', str(tmp_path / 'out'), *words])
    except SystemExit as refused:
        code = refused.code
    assert code == 2
    assert expected in capsys.readouterr().err


def test_topics_are_chosen_alike_in_any_order():
    held = {'/odom', '/reference', '/cmd_vel', '/odom_kf', '/robot2/odom'}
    for others in itertools.permutations(sorted(held), 3):
        topics = dict(zip(('odom', 'reference', 'cmd_vel'), others, strict=True))
        for order in itertools.permutations(topics.items()):
            names, problems = choose_topics('/', dict(order), held)
            assert {name: topic for topic, name in names.items()}.items() >= topics.items(), order
            assert not problems


def test_a_name_that_the_bag_lacks_is_answered_with_what_it_holds(samples, tmp_path):
    recording = read_bag(base(tmp_path / 'bag', samples[:100]), topics={'odom': '/base/odometry'})
    assert ('--topic odom:=/base/odometry: the bag has no /base/odometry; it holds /base/cmd_vel, /base/odom, '
            '/reference') in recording.problems
    recording = read_bag(base(tmp_path / 'none', samples[:100], reference=False))
    assert any('the bag holds /base/cmd_vel, /base/odom: name the robot with --namespace, or its topics with --topic'
               in problem for problem in recording.problems)


def test_only_topics_that_can_be_a_reference_are_offered_as_one():
    names = {f'/{name}': name for name in ('odom', 'cmd_vel', 'reference')}
    odometry, twist = LOOP_TOPICS['odom'].kind, LOOP_TOPICS['cmd_vel'].kind
    held = {'/odom': odometry, '/cmd_vel': twist, '/plan': 'nav_msgs/msg/Path'}
    assert [*missing_topics(names, ['reference'], held)] == [
        f'the bag holds no other topic of type {odometry}: record reference as such']
    assert [*missing_topics(names, ['reference'], held | {'/goal': odometry})] == [
        f'the bag holds /goal of type {odometry}: where one of them is reference, add --topic reference:=/NAME']


def _poses(path, samples, *topics):
    """Write a bag of poses; topics are given with their writers, and how late [s] they are."""
    with BagWriter(path) as writer:
        for sample in samples[:200:10]:
            for topic, write, late in topics:
                stamp = WALL + round((sample.time + late) * 1e9)
                writer.write(f'/{topic}', ODOMETRY, stamp, write(stamp, sample.tick.pose, sample.tick.velocity))
    return path


def test_poses_of_other_frames_are_told_of_and_those_of_other_times_have_no_error_between_them(samples, tmp_path):
    in_map = writing.odometry_writer('map', 'base_link')
    recording = read_bag(_poses(tmp_path / 'bag', samples, ('odom', ODOM, 0), ('reference', in_map, 0),
                                ('ground_truth', in_map, 0)))
    assert "reference is in the frame 'map', odom in 'odom': errors between them mean nothing" in recording.problems
    assert "ground_truth is in the frame 'map', odom in 'odom': it is left out" in recording.problems
    assert not recording.series.has('ground_truth')
    path = _poses(tmp_path / 'apart', samples, ('odom', ODOM, 0), ('reference', ODOM, 3600))
    run = read_run(path, 'apart', '/', lambda _: PARAMETERS, lambda *_: None)
    assert run.metrics == {}
    assert 'no stamp of odom lies between two of reference: there is no tracking error' in run.problems


@pytest.mark.soak
@pytest.mark.timeout(900)
def test_a_bag_of_ten_minutes_is_reported_within_a_minute_and_1_gb(tmp_path):
    path = record(tmp_path / 'bag', rollout(configuration(), 600.0))
    seconds, megabytes = usage_of('-m', 'mobile_robot_control.report.command', path, '--output', tmp_path / 'out')
    # of CPU, since the machine may be busy
    assert seconds < 60.0
    assert megabytes < 1000.0
    assert (tmp_path / 'out' / 'report.html').stat().st_size < 4_000_000


def test_joint_states_that_come_less_often_than_errors_hold_no_error_back(samples, tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        for sample in samples:
            for topic, stamp, message in messages_of(sample):
                if topic != 'joint_states' or stamp % (100 * MS) == 0:
                    writer.write(f'/{topic}', KINDS[topic], WALL + stamp, message)
    run = read_run(tmp_path / 'bag', 'slow', '/', lambda _: PARAMETERS, lambda *_: None)
    expected, _ = measured(PARAMETERS, DURATION)
    assert run.metrics['rms_position_error'] == pytest.approx(expected['rms_position_error'], rel=1e-9)
    assert run.metrics['peak_wheel_torque'] is None
    assert 'joint_states come less often than errors: torques are drawn, but not measured' in run.problems


