"""The parameters of the four nodes as a whole, and robots by name from wherever the package is installed."""

from pathlib import Path

import pytest
from helpers import chapter

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.cart import Placement
from mobile_robot_control.reference.path_parameters import Timing
from mobile_robot_control.settings.configure import (
    ParameterSources,
    configure,
    parameter_sources,
    robot_file,
    shipped_robots,
)
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import NODES, Configuration, course_of

ROBOTS = Path(__file__).parents[3] / 'config' / 'robots'
EVOLVED = {f'gains.{name}': value for name, value in chapter.EVOLVED_VELOCITY_GAINS.items()}


def everywhere(**values):
    return {node: dict(values) for node in NODES}


def refused(values):
    with pytest.raises(ParameterError) as refusal:
        configure(values)
    return refusal.value.violations


def test_violations_of_every_node_are_named_at_once_and_that_of_several_once():
    named = {text.partition(': ')[0]: text.partition(': ')[2] for text in refused({
        'plant': {'duration': -1.0, 'robot.mass': 0.0}, 'velocity_controller': {'gains.k1': 0.0, 'robot.mass': 0.0},
        'position_controller': {'fuzzy.c': [0.0, 1.0, 0.5, 2.0, 3.0], 'controller_type': 'fuzzy'},
        'reference_cart': {'shape': 'trifolium'}})}
    assert sorted(named) == ['plant', 'plant, velocity_controller', 'position_controller', 'reference_cart',
                             'velocity_controller']
    assert named['plant, velocity_controller'] == 'robot.mass = 0.0 is not allowed; it must be above 0.0 kg'


def test_a_node_that_there_is_not_is_refused_with_the_nearest_name():
    assert refused({'position_controler': {'controller_type': 'fuzzy'}, 'plant': {'duration': 1.0}}) == (
        "there is no node 'position_controler'; did you mean 'position_controller'?",)


def test_shared_values_that_differ_between_nodes_are_refused():
    violation, = refused({'plant': {'robot.mass': 12.0}})
    assert violation == ("robot.mass differs between the nodes (plant 12.0, velocity_controller 10.0, "
                         "position_controller 10.0, reference_cart 10.0); write it once, under '/**'")
    violations = refused({'plant': {'velocity_rate': 1000.0, 'lockstep': False}})
    assert [violation.split()[0] for violation in violations] == ['velocity_rate', 'lockstep']


@pytest.mark.parametrize(('velocity_rate', 'position_rate', 'useful'), [
    (500.0, 200.0, ['166.66666666666666', '250.0']), (500.0, 1000.0, ['500.0']),
    (1000.0, 400.0, ['333.3333333333333', '500.0']),
    *((velocity_rate, position_rate, []) for velocity_rate, position_rate in (
        (500.0, 500.0), (4000.0, 4000.0), (20000.0, 50.0), (500.0, 0.5), (1e5, 1.0))),
])
def test_rates_that_do_not_divide_are_refused_with_those_that_do(velocity_rate, position_rate, useful):
    if useful:
        violation, = refused(everywhere(velocity_rate=velocity_rate, position_rate=position_rate))
        assert f'position_rate = {position_rate} Hz does not divide velocity_rate = {velocity_rate} Hz' in violation
        assert violation.endswith(f'take {" or ".join(useful)} Hz')
    for rate in map(float, useful or [position_rate]):
        shared = configure(everywhere(velocity_rate=velocity_rate, position_rate=rate)).plant.shared
        assert (shared.velocity_rate, shared.position_rate) == (velocity_rate, rate)


@pytest.mark.parametrize(('name', 'rate', 'period'), [
    ('velocity_rate', 300.0, '3333333.333 ns'), ('position_rate', 60.0, '16666666.667 ns'),
    ('velocity_rate', 70000.0, '14285.714 ns'),
])
def test_periods_must_be_whole_nanoseconds(name, rate, period):
    violation, = (text for text in refused(everywhere(**{name: rate})) if 'whole nanoseconds' in text)
    assert f'{name} = {rate} Hz has a period of {period}' in violation
    nearest = float(violation.rpartition('the nearest rate is ')[2].removesuffix(' Hz'))
    assert nearest == pytest.approx(1e9 / max(1, round(1e9 / rate)), rel=1e-15)


@pytest.mark.parametrize('factor', [2.3e-308, 1e-13, 5e-7])
def test_a_factor_that_stops_simulated_time_is_refused_with_the_smallest_useful_one(factor):
    violation, = refused({'plant': {'real_time_factor': factor}})
    assert violation.startswith(f'plant: real_time_factor = {factor} is too small: ')
    smallest = float(violation.partition('at least ')[2].partition(',')[0])
    for useful in (smallest * (1.0 + 1e-5), 0.0):
        configure({'plant': {'real_time_factor': useful}})


def test_unstable_gains_are_refused_with_the_slowest_rate_by_the_configured_robot():
    violation, = refused({'velocity_controller': EVOLVED})
    assert violation.startswith('velocity_controller: gains.k1 = 128.444 N s')
    assert 'are unstable at velocity_rate = 500.0 Hz' in violation
    assert 'the slowest stable rate is 1577' in violation or 'the slowest stable rate is 1576' in violation
    # the loop gain is inversely proportional to the inertia: a lighter robot makes the same gains unstable
    light = {'robot.mass': 0.1, 'robot.inertia': 0.001, 'robot.wheel_inertia': 1e-5}
    assert any('are unstable' in violation for violation in refused(everywhere(**light)))
    # a base does not have this loop
    slow = everywhere(velocity_rate=5.0, position_rate=5.0)
    assert 'unstable' in refused(slow)[0]
    slow['plant']['drive'] = 'velocity'
    assert configure(slow).plant.model.drive == 'velocity'


def test_the_chapters_gains_pass_at_4_khz_in_lockstep_alone():
    rates = everywhere(velocity_rate=4000.0, position_rate=4000.0)
    rates['velocity_controller'].update(EVOLVED)
    assert configure(rates).velocity_controller.gains == tuple(chapter.EVOLVED_VELOCITY_GAINS.values())
    for values in rates.values():
        values['lockstep'] = False
    violation, = refused(rates)
    assert 'with one and two samples of delay, as on the wall clock' in violation


@pytest.mark.parametrize(('drive', 'others'), [
    ('torque', {'base.lag': [0.1, 0.1], 'base.command_rate': 20.0}),
    ('velocity', {'max_wheel_torque': 1.0, 'centripetal_coupling': True, 'delay.velocity_steps': 1,
                  'disturbance.step': [0.1, 0.0], 'friction.coulomb': 0.1, 'motor.time_constant': 0.1}),
])
def test_a_parameter_of_the_other_drive_is_refused_by_name(drive, others):
    violations = refused({'plant': {'drive': drive, **others}})
    assert len(violations) == len(others)
    for name, value in others.items():
        assert any(text.startswith(f'plant: {name} = {value} is of plant.drive') and f"drive is '{drive}'" in text
                   for text in violations)


@pytest.mark.parametrize(('parameters', 'named'), [
    ({'drive': 'velocity', 'base.dead_time': [1.0, 0.0]}, 'base.dead_time = [1.0, 0.0] s has more than 64 commands'),
    ({'drive': 'velocity', 'base.command_rate': 1e-4}, 'base.command_rate = 0.0001 Hz is below 0.001 Hz'),
    ({'odometry.latency': 1.0}, 'odometry.latency = 1.0 s with a sample at each position tick keeps 100 samples'),
    ({'encoders.window': 1.0}, 'encoders.window = 1.0 s is 500 periods of the velocity loop'),
])
def test_queues_that_would_be_long_are_refused(parameters, named):
    violation, = refused({'plant': parameters})
    assert violation.startswith(f'plant: {named}')


def test_the_placement_of_an_earlier_file_does_not_count_on_a_path_and_beside_the_path_it_is_refused(tmp_path):
    (tmp_path / 'shelves.csv').write_text('0,0\n2,0\n')
    on_path = 'curve: path, path: {file: shelves.csv}, timing: {max_linear_velocity: 1.0, max_linear_acceleration: 1.0}'
    for name, values in (('tuned', 'curve: lemniscate, scale: 2.0, period: 30.0'), ('path', on_path),
                         ('both', f'{on_path}, period: 30.0')):
        (tmp_path / f'{name}.yaml').write_text(f'/**/reference_cart: {{ros__parameters: {{{values}}}}}\n')
    tuned, path, both = (str(tmp_path / f'{name}.yaml') for name in ('tuned', 'path', 'both'))
    cart = ParameterSources(files=(tuned, path)).configuration().reference_cart
    assert (cart.curve.curve, cart.curve.placement.period) == ('path', Placement().period)
    for files, overrides in (((tuned, both), ()), ((path,), ('reference_cart.period:=30.0',))):
        with pytest.raises(ParameterError, match=r'period = 30\.0 places a curve'):
            ParameterSources(files=files, overrides=overrides).configuration()


@pytest.mark.parametrize(('shared', 'cart', 'words'), [
    ({'feedforward.enabled': True}, {}, 'feedforward.enabled = True needs reference_horizon = 1 or more'),
    ({'reference_horizon': 1}, {'period': 1e-7}, r'acceleration of .* beyond 1e.12; lower the scale or raise'),
])
def test_feedforward_needs_a_horizon_and_a_horizon_accelerations_that_can_be_sent(shared, cart, words):
    with pytest.raises(ParameterError, match=words):
        configure({node: shared | (cart if node == 'reference_cart' else {}) for node in NODES})
    configure({node: shared | {'reference_horizon': 1} for node in NODES})


def test_the_chapters_robot_equals_the_defaults():
    found = configure(load([robot_file('chapter')]))
    # only the limits of paths have no defaults
    assert found.reference_cart.timing != Timing()
    assert found._replace(reference_cart=found.reference_cart._replace(timing=Timing())) == Configuration()


def test_a_path_has_the_limits_of_every_robot_and_the_motors_of_the_plant(tmp_path):
    (tmp_path / 'path.csv').write_text('0,0\n1,0\n1,1\n')
    values = {'reference_cart.curve': 'path', 'reference_cart.path.file': str(tmp_path / 'path.csv')}
    for robot in shipped_robots():
        cart = parameter_sources(robot=robot, parameters=values).configuration().reference_cart
        assert course_of(cart).length == pytest.approx(1.944, abs=0.01)
    with pytest.raises(ParameterError, match=r"friction.coulomb is 0.0 for reference_cart, .* write it under '/\*\*'"):
        parameter_sources(robot='chapter', parameters=values | {'plant.friction.coulomb': 0.01}).configuration()


@pytest.mark.parametrize(('library', 'prefix'), [
    ('lib/python3.11/site-packages', ''), ('lib/python3/dist-packages', ''),
    ('local/lib/python3.12/dist-packages', 'local'), ('', ''),
])
def test_robots_are_found_below_the_prefix_of_an_installed_package(tmp_path_factory, library, prefix):
    place = tmp_path_factory.mktemp('installed')
    package, robots = place / library / 'mobile_robot_control', (
        place / prefix / 'share' / 'mobile_robot_control' / 'config' / 'robots')
    package.mkdir(parents=True)
    assert shipped_robots(place / 'elsewhere' / 'mobile_robot_control') == {}
    robots.mkdir(parents=True)
    (robots / 'one.yaml').touch()
    assert shipped_robots(package) == {'one': robots / 'one.yaml'}


def test_a_robot_is_found_by_its_name_and_what_reads_as_a_path_or_is_a_file_is_one(tmp_path, monkeypatch):
    assert shipped_robots() == {file.stem: file for file in ROBOTS.glob('*.yaml')}
    monkeypatch.chdir(tmp_path)
    for name in ('mine', 'chapter'):
        (tmp_path / name).touch()
    assert robot_file('chapter') == ROBOTS / 'chapter.yaml'
    for path in ('mine', './chapter', 'no/such/file', 'my_robot.yaml', 'my_robot.yml'):
        assert robot_file(path) == Path(path)


@pytest.mark.parametrize('robot', ['chapt', 'zzzzzzzz', '', 'Chapter'])
def test_an_unknown_name_is_refused_with_the_names_there_are(robot):
    with pytest.raises(ParameterError) as refused:
        robot_file(robot)
    violation, = refused.value.violations
    assert f"--robot '{robot}'" in violation
    assert ', '.join(shipped_robots()) in violation
    assert ("did you mean 'chapter'?" in violation) == (robot in ('chapt', 'Chapter'))


def test_a_package_without_robots_says_so(monkeypatch):
    monkeypatch.setattr('mobile_robot_control.settings.configure.shipped_robots', dict)
    with pytest.raises(ParameterError, match=r"'chapter': the package is installed without its robots; name a par"):
        robot_file('chapter')
