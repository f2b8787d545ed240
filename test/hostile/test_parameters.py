"""Parameter services: fuzzed calls are applied whole or refused by name, and what they list can be loaded again."""

import itertools

import pytest
import yaml
from helpers.harness import CONFIG
from helpers.parameter_calls import DECLARED, Call, calls, of, plain, wild
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

from mobile_robot_control.ros.start.arguments import check_ros_arguments
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import NODES

SLOW = ['--params-file', str(CONFIG / 'wall_clock.yaml'), '-p', 'lockstep:=true', '-p', 'real_time_factor:=0.2']
_KINDS = {'get_parameters': GetParameters, 'set_parameters': SetParameters,
          'set_parameters_atomically': SetParametersAtomically}


class Services:
    """The parameter services of the nodes, called from this process; `values` are those that each must hold."""

    def __init__(self, robot, nodes=tuple(NODES)):
        self._robot = robot
        self._clients = {
            (node, name): robot.recorder.create_client(kind, f'{node}/{name}')
            for node in nodes for name, kind in _KINDS.items()
        }
        robot.spin_until(lambda: all(client.service_is_ready() for client in self._clients.values()))
        self.values = {node: self.get(node) for node in nodes}

    def _call(self, node, name, **request):
        return self._robot.call(lambda: self._clients[node, name].call_async(_KINDS[name].Request(**request)))

    def get(self, node):
        """Return all parameters of a node."""
        names = list(DECLARED[node])
        values = self._call(node, 'get_parameters', names=names).values
        return {name: plain(value) for name, value in zip(names, values, strict=True)}

    def set(self, node, messages):
        """Set parameters of a node one by one; returns the result for each."""
        results = self._call(node, 'set_parameters', parameters=messages).results
        assert len(results) == len(messages)
        return results

    def set_atomically(self, node, messages):
        """Set parameters of a node as one; returns the result."""
        return self._call(node, 'set_parameters_atomically', parameters=messages).result


def _each(services, call):
    """Set each parameter by itself, and check its own result."""
    results = services.set(call.node, [setting.message for setting in call.settings])
    for setting, result in zip(call.settings, results, strict=True):
        if setting.good is not None:
            assert result.successful is setting.good, (call, result)
        if result.successful:
            services.values[call.node][setting.message.name] = plain(setting.message.value)
        else:
            assert setting.message.name in result.reason, (call, result)


def _all_or_nothing(services, call):
    """Set all parameters as one: applied if all are valid and none comes twice, else every invalid one is named."""
    result = services.set_atomically(call.node, [setting.message for setting in call.settings])
    names = [setting.message.name for setting in call.settings]
    bad = {name for setting, name in zip(call.settings, names, strict=True) if not setting.good}
    bad |= {name for name in names if names.count(name) > 1}
    assert result.successful is (not bad) or not names, (call, result)
    if result.successful:
        services.values[call.node].update(
            {setting.message.name: plain(setting.message.value) for setting in call.settings})
    else:
        assert result.reason
        for name in bad:
            assert name in result.reason, (call, result)


def _assert_it_is_whole(robot):
    assert {process.exit_code() for process in robot.processes.values()} == {None}
    assert 'Traceback' not in robot.log()


def _assert_it_goes_on(robot, services):
    assert services.set('plant', [of('paused', False)])[0].successful
    services.values['plant']['paused'] = False
    before = robot.time()
    robot.spin_until(lambda: robot.time() > before + 0.01)


def test_fuzzed_calls_are_applied_whole_or_refused_by_name(robot):
    robot.start(arguments=SLOW, composed=True)
    robot.spin_until(lambda: robot.time() > 0.02)
    services, count = Services(robot), itertools.count(1)

    # a failure is not shrunk, since the nodes keep the values of the calls before
    @settings(max_examples=100, phases=[Phase.generate])
    @given(calls())
    def fuzz(call):
        (_all_or_nothing if call.atomically else _each)(services, call)
        assert services.get(call.node) == services.values[call.node], call
        if next(count) % 50 == 0:
            _assert_it_goes_on(robot, services)

    fuzz()
    _assert_it_goes_on(robot, services)
    assert next(count) > 100
    _assert_it_is_whole(robot)


def test_values_that_fit_together_are_accepted_in_any_order(robot):
    robot.start('position_controller')
    services = Services(robot, ['position_controller'])

    def ask(**values):
        messages = [of(f'hybrid_backstepping.{name}', value) for name, value in values.items()]
        return [result.successful for result in services.set('position_controller', messages)]

    def held():
        values = services.get('position_controller')
        return values['hybrid_backstepping.b0'], values['hybrid_backstepping.b1']

    # b1² >= 4 b0: each is refused by itself while the other is what it was
    assert ask(b0=4.0) == [False]
    assert ask(b0=4.0, b1=5.0) == [True, True]
    assert held() == (4.0, 5.0)
    # where one is invalid, each is set by itself, in the order given
    assert ask(b1=1.0, b0=0.2) == [True, True]
    assert ask(b1=5.0, seek_speed=-1.0, b0=4.0) == [True, False, True]
    assert held() == (4.0, 5.0)
    result = services.set_atomically('position_controller', [
        of('hybrid_backstepping.b0', 0.1), of('hybrid_backstepping.seek_speed', -1.0)])
    assert not result.successful
    assert held() == (4.0, 5.0)


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


def test_a_dump_is_loaded_again_by_services_nodes_and_commands(robot, tmp_path):
    (tmp_path / 'small.yaml').write_text(SMALL)
    robot.start(arguments=['--params-file', tmp_path / 'small.yaml'], composed=True)
    clients = {node: Client(robot, node) for node in NODES}
    files = {node: tmp_path / f'{node}.yaml' for node in NODES}
    for node, client in clients.items():
        dumped = client.dump()
        files[node].write_text(yaml.dump(dumped, default_flow_style=False))
        assert client.load(files[node]) == []
        assert client.dump() == dumped
        check_ros_arguments([node], ['--ros-args', '--params-file', str(files[node])])
    assert configure(load(files.values())) == configure(load([tmp_path / 'small.yaml']))
    # of a shipped file the section for all nodes is loaded alone; Jazzy reads the sections of all nodes
    client, file = clients['position_controller'], tmp_path / 'changed.yaml'
    refused, tree = client.load(CONFIG / 'fuzzy.yaml'), client.dump()
    assert all(reason.startswith('unknown parameter ') or 'read-only' in reason for reason in refused)
    assert refused or tree == yaml.safe_load(files['position_controller'].read_text())
    # what can change changes, what cannot is named
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
    # while the recorder takes in their last messages, for which they wait
    robot.stop()


@pytest.mark.soak
@pytest.mark.timeout(600)
def test_controllers_survive_any_gains_that_they_accept(robot):
    """Absurd gains may make the motion diverge, which ends the plant, but never a controller."""
    arguments = ['--params-file', str(CONFIG / 'wall_clock.yaml'), '-p', 'lockstep:=true']
    robot.start(arguments=arguments)
    robot.spin_until(lambda: robot.time() > 0.02)
    services, diverged = Services(robot), []

    @settings(max_examples=150, phases=[Phase.generate])
    @given(st.sampled_from(['position_controller', 'velocity_controller']).flatmap(
        lambda node: st.lists(wild(node), min_size=1, max_size=4, unique_by=lambda setting: setting.message.name).map(
            lambda drawn: Call(node, False, drawn))))
    def fuzz(call):
        before = dict(services.values[call.node])
        _each(services, call)
        after = services.get(call.node)
        assert after == services.values[call.node], call
        if after == before:
            return
        plant, start = robot.processes['plant'], robot.time()
        robot.spin_until(lambda: plant.exit_code() is not None or robot.time() > start + 0.1)
        live = [name for name, declared in DECLARED[call.node].items() if declared.field.live]
        result = services.set_atomically(call.node, [of(name, DECLARED[call.node][name].default) for name in live])
        assert result.successful, result
        services.values[call.node] = services.get(call.node)
        if plant.exit_code() is not None:
            assert plant.exit_code() == 1
            assert 'the motion diverged' in robot.log('plant')
            diverged.append(call)
            robot.recorder.newest.clear()
            robot.start('plant', arguments=arguments)
        robot.spin_until(lambda: robot.time() > 0.02)

    fuzz()
    print(f'{len(diverged)} of 150 calls made the motion diverge')
    _assert_it_is_whole(robot)
