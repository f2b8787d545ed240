"""Every shipped parameter file loads, into the whole and into every node, and names only what is declared."""

import math
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from robots_table import PLACEHOLDER, head, sourced_parameters

from mobile_robot_control.control.laws import BUILT_IN, PositionControl
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.parameters.declaration import declarations, flatten
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.search import command as tune
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load, read_parameter_file
from mobile_robot_control.settings.nodes import NODES, Configuration

CONFIG = Path(__file__).parents[2] / 'config'
FILES = sorted(path for path in CONFIG.rglob('*.yaml') if path.parent.name != 'lessons')
ROBOTS = sorted((CONFIG / 'robots').iterdir())


def _id(path):
    return str(path.relative_to(CONFIG))


def _flat(tree, prefix=''):
    for key, value in tree.items():
        yield from _flat(value, f'{prefix}{key}.') if isinstance(value, dict) else [f'{prefix}{key}']


@pytest.mark.parametrize('path', FILES, ids=_id)
def test_every_shipped_file_loads_with_and_without_a_namespace(path):
    assert configure(load([path], namespace='/robot1')) == configure(load([path]))


@pytest.mark.parametrize('path', FILES, ids=_id)
def test_every_shipped_file_names_declared_parameters_alone(path):
    for section, content in yaml.safe_load(path.read_text()).items():
        if 'tracks' in path.parts and section in ('track', 'published'):
            continue  # of the benchmark, which checks them
        nodes = NODES if section == '/**' else [section.removeprefix('/**/')]
        known = set().union(*(declarations(NODES[node]) for node in nodes))
        assert set(_flat(content['ros__parameters'])) <= known


def test_the_defaults_equal_backstepping_yaml():
    loaded = configure(load([CONFIG / 'backstepping.yaml']))
    for ours, default in zip(loaded, Configuration(), strict=True):
        assert flatten(ours) == flatten(default)


def test_the_file_of_a_further_law_has_its_defaults_beside_the_same_velocity_gains():
    assert {CONFIG / f'{law.name}.yaml' for law in BUILT_IN} <= set(FILES)
    for law in BUILT_IN[3:]:
        loaded = configure(load([CONFIG / f'{law.name}.yaml']))
        assert loaded.position_controller.control == PositionControl(controller_type=law.name)
        assert loaded.velocity_controller.control == Configuration().velocity_controller.control
        assert loaded.velocity_controller.shared.reference_horizon == law.horizon


@pytest.mark.parametrize('path', ROBOTS, ids=_id)
def test_every_number_of_a_robot_has_its_source_above_it(path):
    """A source names a place, a choice its reason, a placeholder why it has its value."""
    text = path.read_text(encoding='utf-8')
    assert len(head(text)) > len(path.stem)
    parameters = sourced_parameters(text)
    written = [(section, name) for section, values in read_parameter_file(path) for name in values]
    assert [(f'/**/{one.node}' if one.node else '/**', one.name) for one in parameters] == written
    for one in parameters:
        kind, colon, reason = one.source.partition(': ')
        assert colon, f'{one.name}: {one.source}'
        assert reason, f'{one.name}: {one.source}'
        assert ('placeholder' in kind.lower()) == one.source.startswith(PLACEHOLDER), f'{one.name}: {one.source}'


@pytest.mark.parametrize('path', ROBOTS, ids=_id)
def test_every_robot_can_drive_its_curve(path):
    """With a fifth of its speed to spare, within its own limits and those of its position controller."""
    configuration = configure(load([path]))
    plant, control = flatten(configuration.plant), flatten(configuration.position_controller)
    curve = configuration.reference_cart.curve
    asked = [reference_at(CURVES[curve.curve], curve.placement.period * n / 1000, curve.placement).velocity
             for n in range(1000)]
    wheel = max(abs(side) for one in asked for side in wheel_velocity(one, configuration.plant.shared.robot))
    assert wheel < 0.8 * (plant['motor.no_load_speed'] or math.inf)
    limits = [*plant['base.max_speed'], control['limits.linear_velocity'], control['limits.angular_velocity']]
    for limit, speeds in zip(limits, [*zip(*asked, strict=True)] * 2, strict=True):
        assert max(map(abs, speeds)) < 0.85 * (limit or math.inf)


def test_the_command_that_found_the_gains_of_a_robot_is_one_of_tune(capsys):
    robots = set()
    for path in ROBOTS:
        for one in sourced_parameters(path.read_text(encoding='utf-8')):
            if one.source.startswith('found by: mrc tune '):
                _, _, *words = shlex.split(one.source.removeprefix('found by: ').partition(';')[0])
                # its options are read, and refused for the last one alone
                assert tune.main([*words, '-p', 'plant.nothing:=1']) == 2
                line, = capsys.readouterr().err.splitlines()
                assert 'nothing' in line
                assert words[words.index('--robot') + 1] == path.stem
                robots.add(path.stem)
    assert robots == {path.stem for path in ROBOTS} - {'chapter'}


@pytest.mark.parametrize('path', ROBOTS, ids=_id)
def test_a_position_controller_carries_odometry_forward_by_its_age_at_a_position_tick(path):
    """A sample that arrives between two ticks waits for the next one; a stamp of when it was taken tells its age."""
    configuration = configure(load([path]))
    plant, control = flatten(configuration.plant), flatten(configuration.position_controller)
    period = 1.0 / plant['position_rate']
    assert plant['odometry.rate'] in (0.0, plant['position_rate'])
    age = period * math.ceil(plant['odometry.latency'] / period - 1e-9)
    told = configuration.plant.shared.stamps_samples
    assert control['odom_latency'] == pytest.approx(0.0 if told else age)
    assert control['compensate_latency'] == (age > 0.0)


@pytest.mark.parametrize('law', ['backstepping', 'hybrid_backstepping', 'fuzzy'])
@pytest.mark.parametrize('curve', ['lemniscate', 'trifolium'])
def test_the_chapter_files_have_the_printed_numbers(curve, law):
    configuration = configure(load([CONFIG / 'chapter' / f'{curve}_{law}.yaml']))
    assert configuration.reference_cart.curve.curve == curve
    assert configuration.position_controller.control.controller_type == law
    assert configuration.plant.shared.velocity_rate == configuration.plant.shared.position_rate == 4000.0
    assert tuple(configuration.velocity_controller.gains) == (128.444, 60.9756, 29.048, 31.4465)
    gains = configuration.position_controller.control.backstepping
    assert law == 'fuzzy' or tuple(gains) == (1.9934, 0.0530, 1.0, 9.8615, 2.9956)


def test_rcl_reads_every_shipped_file_and_every_node_starts_with_those_of_robots(domain):
    """All four nodes in one process, with each file in turn: a refused file ends the process with an error."""
    code = (
        'import sys, rclpy\n'
        'from mobile_robot_control.ros.start.loaded import load\n'
        'from mobile_robot_control.settings.nodes import NODES\n'
        'from mobile_robot_control.ros.start.arguments import check_ros_arguments\n'
        'for path in sys.argv[1:]:\n'
        '    arguments = ["--ros-args", "--params-file", path]\n'
        '    rclpy.init(args=arguments)\n'
        '    for name in NODES:\n'
        '        of_cart = check_ros_arguments([name], arguments)\n'
        '        if "/robots/" in path:\n'
        '            load(name)(*[of_cart] * (name == "reference_cart")).destroy_node()\n'
        '    rclpy.shutdown()\n'
    )
    done = subprocess.run([sys.executable, '-c', code, *map(str, FILES)], capture_output=True, text=True, timeout=100,
                          check=False)
    assert done.returncode == 0, done.stderr
