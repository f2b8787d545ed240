"""What `ros2 param dump` writes can be loaded: by `ros2 param load`, by nodes at their start and by commands."""

import pytest
import yaml
from harness import CONFIG
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.ros.services.ros_arguments import check_ros_arguments

# numbers of which rclpy's client makes texts
SMALL = """
/**/plant: {ros__parameters: {paused: true, duration: 3e+5, noise.pose: [0.0, 1.0e-05, 2.0e-05],
                              pose_covariance_diagonal: [1e-7, 1e-7, 1e-7, 1e-7, 1e-7, 1e-7]}}
/**/position_controller: {ros__parameters: {limits.linear_velocity: 1.0e-05}}
"""


class Client:
    """The calls that `ros2 param dump` and `ros2 param load` make."""

    def __init__(self, robot, node):
        self._robot, self._name = robot, node
        self._client = AsyncParameterClient(robot.recorder, node)
        robot.spin_until(self._client.services_are_ready)

    def dump(self):
        """Return the tree that `ros2 param dump` writes."""
        names = sorted(self._robot.call(self._client.list_parameters).result.names)
        values = self._robot.call(lambda: self._client.get_parameters(names)).values
        tree = {}
        for name, value in zip(names, values, strict=True):
            *groups, leaf = name.split('.')
            group = tree
            for each in groups:
                group = group.setdefault(each, {})
            found = parameter_value_to_python(value)
            group[leaf] = found if isinstance(found, bool | int | float | str) else list(found)
        return {f'/{self._name}': {'ros__parameters': tree}}

    def load(self, file):
        """Load a file as `ros2 param load` does; return the reasons of what was refused."""
        results = self._robot.call(lambda: self._client.load_parameter_file(str(file), use_wildcard=True)).results
        assert results
        return [result.reason for result in results if not result.successful]


@pytest.fixture
def robots(robot, tmp_path):
    small = tmp_path / 'small.yaml'
    small.write_text(SMALL)
    robot.start(arguments=['--params-file', small], composed=True)
    yield robot
    # while the recorder takes in their last messages, for which they wait
    robot.stop()


def test_the_parameters_of_every_node_are_dumped_and_loaded(robots, tmp_path):
    files = []
    for node in NODES:
        client, file = Client(robots, node), tmp_path / f'{node}.yaml'
        dumped = client.dump()
        file.write_text(yaml.dump(dumped, default_flow_style=False))
        assert client.load(file) == []
        assert client.dump() == dumped
        check_ros_arguments([node], ['--ros-args', '--params-file', str(file)])
        files.append(file)
    assert configure(load(files)) == configure(load([tmp_path / 'small.yaml']))


def test_a_loaded_file_changes_what_can_change_and_names_what_cannot(robots, tmp_path):
    client, file = Client(robots, 'position_controller'), tmp_path / 'dump.yaml'
    tree = client.dump()
    values = tree['/position_controller']['ros__parameters']
    values['fuzzy']['a'], values['limits']['angular_velocity'] = 0.25, 2e-05
    file.write_text(yaml.dump(tree, default_flow_style=False))
    assert client.load(file) == []
    assert client.dump() == tree
    values['input_timeout'], values['fuzzy']['a'], values['lockstep'] = 0.75, 0.5, 1
    file.write_text(yaml.dump(tree, default_flow_style=False))
    refused = client.load(file)
    assert len(refused) == 2
    assert all('read-only while the node runs' in reason for reason in refused)
    after = client.dump()['/position_controller']['ros__parameters']
    assert (after['input_timeout'], after['fuzzy']['a'], after['lockstep']) == (0.5, 0.5, True)


def test_of_a_shipped_file_the_section_for_all_nodes_is_loaded_alone(robots):
    client = Client(robots, 'position_controller')
    before = client.dump()
    refused = client.load(CONFIG / 'fuzzy.yaml')
    if refused:  # Jazzy reads the sections of all nodes
        assert all(reason.startswith('unknown parameter ') or 'read-only' in reason for reason in refused)
    else:
        assert client.dump() == before
