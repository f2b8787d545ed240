"""Nodes in processes of their own, started and observed over DDS: the harness of all tests that need them."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import rclpy
from commands import command_modules
from mcap.reader import make_reader
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_srvs.srv import Trigger

from helpers.warm_nodes import WarmNode
from mobile_robot_control.experiment.node_processes import PROFILES_VARIABLES, stop_processes
from mobile_robot_control.experiment.recorder import Recorder
from mobile_robot_control.messages.parsing import serialised_stamp
from mobile_robot_control.ros.start.spin import make_executor
from mobile_robot_control.runs import bag
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.topics import LOOP_TOPICS, LOOPS

CONFIG = Path(__file__).parents[2] / 'config'
TURN = 0.005
"""[s] in which messages are taken in before a condition is looked at again."""
PERIOD = 2_000_000
"""[ns] of the velocity grid in lockstep, unless a test chooses another."""


def numbers_in(path):
    """Return the content of a JSON file without what it was made with."""
    def numbers(found):
        return {name: value for name, value in found.items() if name != 'provenance'}

    return json.loads(path.read_text(), object_hook=numbers)


def run_command(name, *arguments, timeout=180):
    """Run a command of the package to its end."""
    return subprocess.run(
        [sys.executable, '-m', command_modules()[name], *map(str, arguments)],
        capture_output=True, text=True, timeout=timeout, check=False,
    )


def experiment(output, *arguments, report=False):
    """Run an experiment as fast as it goes; returns its metrics and its recording."""
    done = run_command('experiment', '--output', output, '-p', 'plant.real_time_factor:=0.0',
                       *([] if report else ['--no-report']), *arguments)
    assert done.returncode == 0, done.stderr
    return numbers_in(output / 'metrics.json'), bag.read_bag(output / 'bag')


def start_experiment(output, *arguments, report=False):
    """Start an experiment, and wait until its progress bar has passed a simulated second."""
    run = subprocess.Popen(
        [sys.executable, '-m', 'mobile_robot_control.experiment.command', '--output', str(output),
         *([] if report else ['--no-report']), *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )
    shown = ''
    while not re.search(r'\| [1-9]\d*\.\d/', shown):
        read = run.stderr.read(1)
        assert read, shown
        shown += read
    return run


@contextlib.contextmanager
def _announced_seldom():
    """
    Make participants of this process that announce themselves as seldom as by default.

    Where one announces itself while a peer leaves and writers are deleted, Fast DDS may deadlock:
    https://github.com/eProsima/Fast-DDS/issues/6502
    """
    given = {name: Path(os.environ[name]) for name in PROFILES_VARIABLES if name in os.environ}
    for name, path in given.items():
        quiet = path.with_name(f'quiet_{path.name}')
        quiet.write_text(re.sub('<discovery_config>.*</discovery_config>', '', path.read_text(), flags=re.DOTALL))
        os.environ[name] = str(quiet)
    try:
        yield
    finally:
        os.environ.update({name: str(path) for name, path in given.items()})


class Robots:
    """
    One robot, or several in namespaces of one ROS domain: their nodes as processes, and a recorder of each robot here.

    Bags and logs are in the folder; without namespaces to record, recorders take no CPU time from the nodes. A run
    waits until each topic of `loop` is recorded. `processes` are by the node's name, with its namespace where it has
    one: 'plant', 'robot1/plant'; `recorders` are by namespace.
    """

    def __init__(self, folder, namespaces=('/',), loop=LOOPS['torque']):
        folder.mkdir(exist_ok=True)
        self.loop = loop
        self._folder = folder
        self.processes, self.recorders, self._clients = {}, {}, {}
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self._executor = make_executor()
        self._bags, self._bags_are_closed = contextlib.ExitStack(), False
        for namespace in namespaces:
            bag = self._bags.enter_context(BagWriter(self._bag(namespace)))
            with _announced_seldom():
                self.recorders[namespace] = Recorder(namespace, bag.write, bag.knows, self.loop)
            self.add(self.recorders[namespace])

    def _bag(self, namespace):
        return self._folder / f'bag{namespace.rstrip("/").replace("/", "_")}'

    @property
    def recorder(self):
        """The recorder of the only robot."""
        recorder, = self.recorders.values()
        return recorder

    def add(self, node):
        """Spin another node of this process along with the recorders."""
        self._executor.add_node(node)

    def start(self, *names, namespace='/', arguments=(), composed=False):
        """Start nodes, all unless named, each as a process or composed in one, which takes a third of the time."""
        names = names or self.loop.nodes
        for together in [names] if composed else [(name,) for name in names]:
            full = [f'{namespace}/{name}'.lstrip('/') for name in together]
            log = self._folder / f'{len(list(self._folder.glob("*.log"))):02}_{"_".join(full).replace("/", "_")}.log'
            # a forked node opens it when it has its first turn
            log.touch()
            remap = [] if namespace == '/' else ['-r', f'__ns:={namespace}']
            process = WarmNode(together, ['--ros-args', *map(str, arguments), *remap], log)
            self.processes.update(dict.fromkeys(full, process))

    def stop(self, *names, number=signal.SIGINT):
        """Send a signal to nodes, to all unless named; each must end with exit code 0 within 10 s."""
        stopped = list(dict.fromkeys(self.processes[name] for name in names or self.processes))
        for process in stopped:
            process.signal(number)
        self.spin_until(lambda: all(process.exit_code() is not None for process in stopped))
        assert [process.exit_code() for process in stopped] == [0] * len(stopped), self.log()

    def _plant_has_ended(self, namespace):
        plant = self.processes.get(f'{namespace}/plant'.lstrip('/'))
        return plant is not None and plant.exit_code() is not None

    def finish(self, seconds=60.0):
        """Spin until every plant has ended, with exit code 0."""
        plants = [process for name, process in self.processes.items() if name.endswith('plant')]
        self.spin_until(lambda: all(plant.exit_code() is not None for plant in plants), seconds)
        assert [plant.exit_code() for plant in plants] == [0] * len(plants), self.log()

    def log(self, name=''):
        """Return what a node, or the process that it is in, has printed over all its runs; or all nodes."""
        paths = [path for path in sorted(self._folder.glob('*.log')) if name in path.name]
        assert paths or not name, f'{name} has not been started'
        return ''.join(path.read_text() for path in paths)

    def time(self, namespace='/'):
        """Return the stamp of a robot's newest joint states [s]."""
        return self.recorders[namespace].newest.get('joint_states', -1) / 1e9

    def spin_until(self, condition, seconds=60.0):
        """Take in messages until a condition holds; fail if it does not in time, or if a node refuses to start."""
        deadline = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < deadline, (
                f'the condition did not hold within {seconds} s; t = {[*map(self.time, self.recorders)]} s', self.log())
            refused = [process.exit_report() for process in self.processes.values() if process.exit_code() == 2]
            assert not refused, refused
            # not once a message: on a busy machine the recorder would fall behind, and answers wait with its messages
            self._executor.spin_until_future_complete(Future(), TURN)

    def wait_at(self, seconds, *topics):
        """Take in messages until every node, or those that publish these topics, has answered a time [s]."""
        newest = self.recorder.newest
        self.spin_until(lambda: {newest[topic] for topic in topics or newest} == {round(seconds * 1e9)})

    def listen(self, seconds):
        """Take in messages for a while."""
        end = time.monotonic() + seconds
        self.spin_until(lambda: time.monotonic() > end, seconds + 5.0)

    def call(self, send, every=1.0, done=lambda: False):
        """
        Call a service, and again after some time [s] without a response; returns the first one, None if done before.

        A call before discovery is lost, and so is a response to a client that the node has not discovered yet.
        """
        calls, begun = [], time.monotonic()

        def answered():
            if time.monotonic() >= begun + every * len(calls):
                calls.append(send())
            return any(call.done() for call in calls) or done()

        self.spin_until(answered)
        return next((call.result() for call in calls if call.done()), None)

    def resume(self):
        """Let every paused plant go on, once all topics of its robot are recorded."""
        for namespace, recorder in self.recorders.items():
            self.spin_until(recorder.has_every_topic)
            # a plant may end before its answer has arrived; that of another robot says nothing about this one
            self.call(lambda recorder=recorder: recorder.resume(PERIOD),
                      done=lambda namespace=namespace: self._plant_has_ended(namespace))

    def _ask_to_set(self, node, values, done=lambda: False):
        client = self._known_client(SetParameters, node, 'set_parameters')
        return self.call(lambda: client.call_async(SetParameters.Request(parameters=[
            Parameter(name.replace('__', '.'), value=value).to_parameter_msg() for name, value in values.items()
        ])), every=10.0, done=done)

    def set(self, node, **values):
        """Set parameters of a node, with two underscores for the dot in a name; returns the result for each."""
        results = self._ask_to_set(node, values).results
        assert len(results) == len(values)
        return results

    def release(self):
        """Let a held plant drive to its end; it may end before its answer has arrived."""
        answer = self._ask_to_set('plant', {'hold_at': 0.0}, lambda: self._plant_has_ended('/'))
        assert answer is None or answer.results[0].successful
        self.finish()

    def writers(self, node):
        """Return what the only robot's recorder knows a node's publishers on the loop's topics by."""
        return {bytes(one.endpoint_gid) for name, topic in self.loop.topics.items() if topic.publisher == node
                for one in self.recorder.get_publishers_info_by_topic(self.recorder.resolve_topic_name(name))}

    def trigger(self, service):
        """Call a service without arguments, once unless the answer is lost; returns success and message."""
        client = self._known_client(Trigger, *service.rsplit('/', 1))
        answer = self.call(lambda: client.call_async(Trigger.Request()), every=10.0)
        return answer.success, answer.message

    def _known_client(self, kind, node, service):
        """Return a client of a service that its node has discovered: no answer is lost, and one call is enough."""
        # by the processes, too: a node that was started again has to discover it again
        key = node, service, *(process.pid for process in self.processes.values())
        if key not in self._clients:
            self._clients[key] = self.recorder.create_client(kind, f'{node}/{service}')
            self.spin_until(self._clients[key].service_is_ready)
            # a node discovers clients in their order: one that answers a later one knows this one
            later = self.recorder.create_client(GetParameters, f'{node}/get_parameters')
            self.spin_until(later.service_is_ready)
            self.call(lambda: later.call_async(GetParameters.Request()))
        return self._clients[key]

    def _closed_bag(self, namespace):
        """Close the bags once no message of a loop topic comes for half a second."""
        if not self._bags_are_closed:
            for recorder in self.recorders.values():
                recorder.drain(lambda: self._executor.spin_once(timeout_sec=0.05), 0.5, 60.0)
            self._bags.close()
            self._bags_are_closed = True
        return self._bag(namespace)

    def recording(self, namespace='/'):
        """Close the bags, and read a robot's."""
        return bag.read_bag(self._closed_bag(namespace), namespace)

    def messages(self, namespace='/'):
        """Close the bags, and read a robot's serialised messages: `[relative topic][stamp]` is the set of them."""
        found = {topic: {} for topic in LOOP_TOPICS}
        bag = self._closed_bag(namespace)
        with (bag / f'{bag.name}.mcap').open('rb') as file:
            for _, channel, message in make_reader(file).iter_messages():
                topic = channel.topic.removeprefix(namespace.rstrip('/') + '/')
                if topic in found:
                    found[topic].setdefault(serialised_stamp(message.data), set()).add(message.data)
        return found

    def _see_peers_leave(self):
        """
        Wait until no other participant is discovered; one that was killed stays for its lease, and leaves at no time
        that matters here.

        While one leaves, Fast DDS may deadlock where writers are deleted:
        https://github.com/eProsima/Fast-DDS/issues/6502
        """
        ours = {node.get_name() for node in self._executor.get_nodes()}
        deadline = time.monotonic() + 2.0
        while (any(set(node.get_node_names()) - ours for node in self._executor.get_nodes())
               and time.monotonic() < deadline):
            time.sleep(0.01)

    def close(self):
        """End all processes and leave the domain."""
        with contextlib.ExitStack() as ending:
            for step in (rclpy.try_shutdown, self._bags.close, self._executor.shutdown):
                ending.callback(step)
            stop_processes(list(dict.fromkeys(self.processes.values())))
            self._see_peers_leave()


@contextlib.contextmanager
def driven(folder, arguments, loop=LOOPS['torque'], composed=True):
    """
    Run robots to their end and yield them.

    The arguments of each, by namespace, say that it is `paused`, that its `real_time_factor` is 0, and its `duration`.
    """
    with contextlib.closing(Robots(folder, tuple(arguments), loop)) as robots:
        for namespace, own in arguments.items():
            robots.start(namespace=namespace, arguments=own, composed=composed)
        robots.resume()
        robots.finish(180.0)
        yield robots
