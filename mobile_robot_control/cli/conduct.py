"""Start the nodes of an experiment, record them, and watch over them to the end."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import rclpy
from rclpy.executors import Executor
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.cli import transport
from mobile_robot_control.cli.processes import NodeProcess
from mobile_robot_control.cli.processes import stop as stop_processes
from mobile_robot_control.cli.progress import Progress
from mobile_robot_control.configuration import NODES, Configuration, period_nanoseconds
from mobile_robot_control.parameters import ParameterError
from mobile_robot_control.recording.bag_writer import BagWriter
from mobile_robot_control.ros.executables import Stop
from mobile_robot_control.ros.recorder import Recorder
from mobile_robot_control.ros.spin import make_executor

_START = 30.0
"""[s] of wall time that the nodes have to start."""
_SETTLE = 1.0
"""[s] of wall time in which rivals are looked for, before a run and again and again in it."""


_SOURCES = {
    'odom': 'plant', 'joint_states': 'plant', 'reference': 'reference_cart', 'cmd_vel': 'position_controller',
    'tracking_error': 'position_controller', 'wheel_torques': 'velocity_controller',
}


class Conducted(NamedTuple):
    """
    How an experiment ended.

    Attributes
    ----------
    outcome : str
        'completed', 'diverged', 'interrupted' or 'node_died'.
    reason : str
        What went wrong, naming the node or the file; '' where nothing did.

    """

    outcome: str
    reason: str


def _refuse_rivals(topics: list[str]) -> None:
    if topics:
        raise ParameterError([f'somebody else publishes on {", ".join(topics)}; '
                              'stop the other robot, or choose another --namespace or ROS_DOMAIN_ID'])


class _Conductor:
    """Has the processes of one experiment and knows how far it is."""

    def __init__(
        self, parameters: Configuration, output: Path, namespace: str, patience: float, stop: Stop, recorder: Recorder,
        executor: Executor, bag: BagWriter, progress: Progress,
    ) -> None:
        self.processes: list[NodeProcess] = []
        self._output, self._namespace, self._patience = output, namespace, patience
        self._stop, self._recorder, self._executor, self._bag, self._progress = stop, recorder, executor, bag, progress
        shared = parameters.plant.shared
        self.lockstep = shared.lockstep
        self._period = period_nanoseconds(shared.velocity_rate)
        self._end = round(parameters.plant.duration * shared.velocity_rate) * self._period
        self._position_period = period_nanoseconds(shared.position_rate)

    def start(self, *names: str) -> None:
        arguments = ['--ros-args', '--params-file', str(self._output / 'parameters.yaml'), '-p', 'paused:=true']
        if self._namespace != '/':
            arguments += ['-r', f'__ns:={self._namespace}']
        self.processes.append(NodeProcess(names, arguments, self._output / 'log' / f'{"_".join(names)[:60]}.log'))

    def spin_until(self, condition: Callable[[], Any], seconds: float) -> bool:
        """Spin until a condition holds; False when time is up or the run is over."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline or self._over():
                return False
            self._executor.spin_once(timeout_sec=0.05)
        return True

    def let_time_run(self) -> None:
        """Tell the paused plant to go on, until it has heard it."""
        deadline = time.monotonic() + self._patience
        while not self.spin_until(self._recorder.let_run(self._period if self.lockstep else 0).done, 1.0):
            if time.monotonic() > deadline or self._over():
                return

    def drain(self) -> None:
        """Take in what has arrived and is not recorded yet."""
        ended = time.time_ns()
        # a rival robot never falls silent
        while time.time_ns() - max(ended, self._recorder.received) < 0.3e9 and time.time_ns() < ended + 5e9:
            self._executor.spin_once(timeout_sec=0.05)

    def _over(self) -> bool:
        """Say whether a stop is asked for, a process has ended, or nothing more can be recorded."""
        ended = any(process.exit_code() is not None for process in self.processes)
        return ended or self._stop.requested or bool(self._bag.failure)

    def watch(self) -> None:
        """Spin with a progress bar until the run is over, or nothing moves any more."""
        newest, moved, end = -1, time.monotonic(), self._end / 1e9
        start = 0 if self.lockstep else self._recorder.newest['joint_states']
        looked = 0.0
        with self._progress.part() as bar:
            while not self._over():
                self._executor.spin_once(timeout_sec=0.05)
                if time.monotonic() > looked + _SETTLE:
                    looked = time.monotonic()
                    _refuse_rivals(self._recorder.rivals(ours=1))
                now = self._reached()
                if now != newest:
                    newest, moved = now, time.monotonic()
                    done = min((now - start) / 1e9, end)
                    if done - bar.n >= 0.05:
                        bar.update(done - bar.n)
                elif time.monotonic() - moved > self._patience:
                    return
            bar.update(max(0.0, min((newest - start) / 1e9, end) - bar.n))

    def _reached(self) -> int:
        """Give the stamp up to which the run has moved: on the wall clock, where nobody waits, for every node."""
        newest = self._recorder.newest
        return newest['joint_states'] if self.lockstep else min(newest.get(topic, -1) for topic in _SOURCES)

    def verdict(self) -> Conducted:
        if self._stop.requested or self._bag.failure:
            return Conducted('interrupted', '')
        for process in self.processes:
            code = process.exit_code()
            if code == 0 and 'plant' in process.name:
                return Conducted('completed', '')
            if code == 1 and 'plant' in process.name:
                return Conducted('diverged', process.obituary())
        dead = [process for process in self.processes if process.exit_code() is not None]
        if dead:
            return Conducted('node_died', '\n'.join(process.obituary() for process in dead))
        return Conducted('node_died', f'{self._silent()} gave no answer for {self._patience} s and was given up')

    def _silent(self) -> str:
        """Name the first node of the chain that owes an answer; on the wall clock, the one that fell silent first."""
        newest = self._recorder.newest
        if 'joint_states' not in newest:
            return 'plant'
        if not self.lockstep:
            return _SOURCES[min(_SOURCES, key=lambda topic: newest.get(topic, -1))]
        tick = newest['joint_states'] - newest['joint_states'] % self._position_period
        for topic, node in (('odom', 'plant'), ('reference', 'reference_cart'), ('cmd_vel', 'position_controller')):
            if newest.get(topic, -1) != tick:
                return node
        return 'velocity_controller' if newest.get('wheel_torques', -1) != newest['joint_states'] else 'plant'


def conduct(
    parameters: Configuration, output: Path, namespace: str, composed: bool, patience: float, stop: Stop,
    progress: Progress,
) -> Conducted:
    """
    Run an experiment and record it.

    Parameters
    ----------
    parameters : Configuration
        Checked; `parameters.yaml` in the folder says the same.
    output : Path
        Takes the bag and the nodes' logs.
    namespace : str
        In which the nodes run.
    composed : bool
        All four nodes in one process.
    patience : float
        Wall time without progress after which the run is given up [s].
    stop : Stop
        A request to end.
    progress : Progress
        Shows how far the run is.

    Returns
    -------
    Conducted
        Outcome and reason; the bag is whole, or can be read up to where it could no longer be written.

    Raises
    ------
    ParameterError
        If another robot is there already.

    """
    transport.settle(output / 'log')
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        with BagWriter(output / 'bag') as bag:
            recorder = Recorder(namespace, bag.write, bag.knows)
            executor = make_executor()
            executor.add_node(recorder)
            conductor = _Conductor(parameters, output, namespace, patience, stop, recorder, executor, bag, progress)
            conductor.spin_until(recorder.rivals, _SETTLE)
            _refuse_rivals(recorder.rivals())
            try:
                conducted = _perform(conductor, composed, patience, recorder)
            finally:
                stop_processes(conductor.processes)
                conductor.drain()
        return conducted._replace(reason='\n'.join(filter(None, (conducted.reason, bag.failure))))
    finally:
        rclpy.try_shutdown()


def _perform(conductor: _Conductor, composed: bool, patience: float, recorder: Recorder) -> Conducted:
    if composed:
        conductor.start(*NODES)
    else:
        for name in NODES:
            conductor.start(name)
    # the plant is paused: it repeats its first messages until they and every answer to them have been recorded
    ready = recorder.hears_everything if conductor.lockstep else recorder.all_hear_each_other
    if conductor.spin_until(ready, max(patience, _START)):
        conductor.let_time_run()
        conductor.watch()
    return conductor.verdict()
