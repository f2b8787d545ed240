"""Robots in namespaces of one domain: their processes, and what is heard of each, by topic and stamp."""

import os
import time

import rclpy
from harness import PERIOD
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.cli import fastdds_profiles
from mobile_robot_control.cli.node_processes import NodeProcess, stop_processes
from mobile_robot_control.messages.parsing import serialised_stamp
from mobile_robot_control.parameters.nodes import NODES
from mobile_robot_control.ros.recorder import Recorder
from mobile_robot_control.ros.spin import make_executor
from mobile_robot_control.topics import LOOP_TOPICS


class Fleet:
    """
    The processes of several robots, and one listener for each in this process.

    Its messages are kept as they came: `heard[namespace][topic][stamp]` is the set of what was said with that stamp.
    """

    def __init__(self, folder, namespaces, monkeypatch):
        folder.mkdir()
        if namespaces:
            fastdds_profiles.use_fastdds_profiles(folder)
            # the settings are for this test alone
            monkeypatch.setenv(fastdds_profiles.PROFILES_VARIABLE, os.environ.pop(fastdds_profiles.PROFILES_VARIABLE))
        self._folder = folder
        self.processes = {}
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self._executor = make_executor()
        self.heard = {namespace: {topic: {} for topic in LOOP_TOPICS} for namespace in namespaces}
        self.recorders = {namespace: Recorder(namespace, self._sink(namespace), lambda _: True)
                          for namespace in namespaces}
        for recorder in self.recorders.values():
            self.add(recorder)

    def add(self, node):
        """Let a node of this process take part."""
        self._executor.add_node(node)

    def _sink(self, namespace):
        prefix = namespace.rstrip('/') + '/'

        def take(topic, _kind, _received, message, _latched):
            by_stamp = self.heard[namespace].get(topic.removeprefix(prefix))
            if by_stamp is not None:
                by_stamp.setdefault(serialised_stamp(message), set()).add(message)

        return take

    def start(self, namespace, arguments, composed=True):
        """Start the four nodes of a robot, in one process or each in its own."""
        for names in [tuple(NODES)] if composed else [(name,) for name in NODES]:
            log = self._folder / f'{namespace.strip("/") or "robot"}_{"_".join(names)[:40]}.log'
            self.processes[namespace, names] = NodeProcess(
                names, ['--ros-args', *map(str, arguments), '-r', f'__ns:={namespace}'], log)

    def logs(self):
        """All that the nodes have printed."""
        return ''.join(path.read_text() for path in sorted(self._folder.glob('*.log')))

    def time(self, namespace):
        """Simulated time of a robot [s]."""
        return self.recorders[namespace].newest.get('joint_states', -1) / 1e9

    def spin_until(self, condition, seconds=30.0):
        """Listen until a condition holds."""
        deadline = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < deadline, f'waited {seconds} s in vain\n{self.logs()}'
            self._executor.spin_once(timeout_sec=0.05)

    def listen(self, seconds):
        """Listen for a while."""
        end = time.monotonic() + seconds
        self.spin_until(lambda: time.monotonic() > end, seconds + 5.0)

    def go_on(self):
        """Let time run for every robot that is started, once all of each is heard."""
        for namespace in {namespace for namespace, _ in self.processes}:
            recorder, asked = self.recorders[namespace], []
            self.spin_until(recorder.has_every_topic)

            def answered(recorder=recorder, asked=asked):
                if not asked or time.monotonic() > asked[-1][0] + 1.0:
                    asked.append((time.monotonic(), recorder.resume(PERIOD)))
                return any(answer.done() for _, answer in asked)

            self.spin_until(answered)

    def finish(self, seconds=60.0):
        """Listen until every plant has ended with 0 and all that it and the others said has come."""
        plants = [process for (_, names), process in self.processes.items() if 'plant' in names]
        self.spin_until(lambda: all(plant.exit_code() is not None for plant in plants), seconds)
        assert [plant.exit_code() for plant in plants] == [0] * len(plants), self.logs()
        self.listen(0.3)

    def close(self):
        """Leave nothing behind."""
        stop_processes(list(self.processes.values()))
        self._executor.shutdown()
        rclpy.try_shutdown()
