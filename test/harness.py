"""Real nodes in real processes: what the tests over DDS have in common."""

import contextlib
import json
import re
import subprocess
import sys
import time
from pathlib import Path

import rclpy
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.cli.node_processes import NodeProcess, stop_processes
from mobile_robot_control.parameters.nodes import NODES
from mobile_robot_control.recording import bag_reader
from mobile_robot_control.recording.bag_writer import BagWriter
from mobile_robot_control.ros.recorder import Recorder
from mobile_robot_control.ros.spin import make_executor

CONFIG = Path(__file__).parents[1] / 'config'
PERIOD = 2_000_000
"""[ns] of the velocity grid in lockstep, unless a test chooses another."""


def run_command(name, *arguments, timeout=90):
    """Run a command of the package to its end."""
    return subprocess.run(
        [sys.executable, '-m', f'mobile_robot_control.cli.{name}', *map(str, arguments)],
        capture_output=True, text=True, timeout=timeout, check=False,
    )


def experiment(output, *arguments, timeout=90, report=False):
    """Run an experiment as fast as it goes; returns its metrics and its recording."""
    drawn = [] if report else ['--no-report']
    done = run_command('experiment', '--output', output, '-p', 'plant.real_time_factor:=0.0', *drawn, *arguments,
                       timeout=timeout)
    assert done.returncode == 0, done.stderr
    return json.loads((output / 'metrics.json').read_text()), bag_reader.read_bag(output / 'bag')


def start_experiment(output, *arguments, report=False):
    """Start an experiment."""
    drawn = [] if report else ['--no-report']
    return subprocess.Popen(
        [sys.executable, '-m', 'mobile_robot_control.cli.experiment', '--output', str(output), *drawn,
         *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )


def node_pid(output, name):
    """Find a node of an experiment by the parameter file that it was given."""
    for process in Path('/proc').glob('[0-9]*'):
        with contextlib.suppress(OSError):
            words = (process / 'cmdline').read_text().split('\0')
            if name in words and str(output / 'parameters.yaml') in words:
                return int(process.name)
    return None


def wait_until_it_moves(run):
    """Read an experiment's progress bar up to a simulated second."""
    shown = ''
    while not re.search(r'\| [1-9]\d*\.\d/', shown):
        read = run.stderr.read(1)
        assert read, shown
        shown += read


class Robot:
    """The nodes of one run, and a recorder in this process that hears them."""

    def __init__(self, folder):
        self._folder = folder
        self.processes = {}
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self._bag = BagWriter(folder / 'bag')
        self._bag.__enter__()
        self.recorder = Recorder('/', self._bag.write, self._bag.knows)
        self._executor = make_executor()
        self._executor.add_node(self.recorder)

    def start(self, *names, arguments=(), composed=False):
        """Start nodes, each in a process of its own or all in one, which takes a third of the time."""
        names = names or tuple(NODES)
        for together in [names] if composed else [(name,) for name in names]:
            log = self._folder / f'{len(list(self._folder.glob("*.log")))}_{"_".join(together)}.log'
            process = NodeProcess(together, ['--ros-args', *arguments], log)
            self.processes.update(dict.fromkeys(together, process))

    def log(self, name=''):
        """All that a node, or the process that it is in, has printed over all its lives; or all of them."""
        paths = sorted(self._folder.glob('*.log'))
        return ''.join(path.read_text() for path in paths if name in path.name)

    def time(self):
        """Simulated time [s]."""
        return self.recorder.newest.get('joint_states', -1) / 1e9

    def spin_until(self, condition, seconds=30.0):
        """Listen until a condition holds."""
        deadline = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < deadline, f'waited {seconds} s in vain at t = {self.time()} s\n{self.log()}'
            refused = [process.exit_report() for process in self.processes.values() if process.exit_code() == 2]
            assert not refused, refused
            self._executor.spin_once(timeout_sec=0.05)

    def listen(self, seconds):
        """Listen for a while."""
        end = time.monotonic() + seconds
        self.spin_until(lambda: time.monotonic() > end, seconds + 5.0)

    def go_on(self):
        """Tell the paused plant to go on, until it answers."""
        answers = []

        def answered():
            if not answers or time.monotonic() > asked[-1] + 1.0:
                answers.append(self.recorder.resume(PERIOD))
                asked.append(time.monotonic())
            return any(answer.done() for answer in answers)

        asked = []
        self.spin_until(answered)

    def set(self, node, **values):
        """Set parameters of a node, with two underscores for the dot in a name; returns what it says to each."""
        client = self.recorder.create_client(SetParameters, f'{node}/set_parameters')
        self.spin_until(client.service_is_ready)
        answer = client.call_async(SetParameters.Request(parameters=[
            Parameter(name.replace('__', '.'), value=value).to_parameter_msg() for name, value in values.items()
        ]))
        self.spin_until(answer.done)
        return answer.result().results

    def recording(self):
        """Close the bag and read it."""
        self.spin_until(lambda: time.time_ns() - self.recorder.received > 0.5e9)
        self._bag.__exit__(None, None, None)
        return bag_reader.read_bag(self._folder / 'bag')

    def close(self):
        """Leave nothing behind."""
        stop_processes(list(dict.fromkeys(self.processes.values())))
        self._executor.shutdown()
        rclpy.try_shutdown()
