"""The experiment runner: it starts the nodes of a run, records, and watches them to the end."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.experiment.node_processes import START, NodeProcess, stop_processes, use_fastdds_profiles
from mobile_robot_control.experiment.recorder import AHEAD, Recorder
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import period_nanoseconds
from mobile_robot_control.ros.shared.process import Stop
from mobile_robot_control.ros.start.spin import RCLError, make_executor, one_line
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.settings.nodes import Configuration, loop_of
from mobile_robot_control.system.progress import RunProgress, tqdm
from mobile_robot_control.system.supervisor import Supervisor, is_suspended, keep_node, shut_down
from mobile_robot_control.topics import silent_node


class RunFailedError(Exception):
    """A run that cannot continue as requested; the text is the reason."""


class ExperimentResult(NamedTuple):
    """
    The end of an experiment.

    Attributes
    ----------
    outcome : str
        'completed', 'diverged', 'law_failed', 'interrupted' or 'node_died'.
    reason : str
        The error, with the node or the file; '' without one.

    """

    outcome: str
    reason: str


SETTLE = 1.0
"""[s] of wall time for finding other publishers, before a run and repeatedly during it."""
_STANDSTILL = 1.0
"""[s] of wall time, at most, for which a run continues after its law has failed."""
_BEHIND = 20.0
"""[s] of wall time, at most, for recording what arrived while this process could not run."""


class Procedure(Protocol):
    """A procedure for a run that is paused at its start: a replay."""

    def attach(self, namespace: str) -> Node:
        """Return the node that the procedure uses."""

    def follow(self, runner: 'ExperimentRunner') -> None:
        """Execute the procedure, as far as the run goes; raise RunFailedError if that is impossible."""


def refuse_other_publishers(topics: list[str]) -> None:
    """Raise ParameterError if others publish on topics."""
    if topics:
        raise ParameterError([f'another node publishes on {", ".join(topics)}; '
                              'stop the other robot, or choose another --namespace or ROS_DOMAIN_ID'])


class ExperimentRunner:
    """
    The processes of one experiment and its progress.

    DDS discovery takes up to seconds, and a run must not begin before its recorder receives all of it: nodes start
    `paused`. In lockstep the run begins once the cart's path and a message on every loop topic are recorded, since a
    paused plant repeats t = 0 and every node its answers; `hold_at` then keeps the plant no further ahead than
    publishers store messages. On the wall clock it begins once every node has found the recorder, by its diagnostics.
    """

    def __init__(
        self, parameters: Configuration, output: Path, namespace: str, patience: float, stop: Stop, recorder: Recorder,
        turn: Callable[[], None], bag: BagWriter, bar: tqdm,
    ) -> None:
        self.processes: list[NodeProcess] = []
        self.recorder, self.patience = recorder, patience
        self._output, self._namespace = output, namespace
        self._stop, self._turn, self._bag, self._bar = stop, turn, bag, bar
        shared, self.loop = parameters.plant.shared, loop_of(parameters.plant)
        self.lockstep = shared.lockstep
        self._period = period_nanoseconds(shared.velocity_rate)
        self._end = round(parameters.plant.duration * shared.velocity_rate) * self._period
        self._position_period = period_nanoseconds(shared.position_rate)
        self._progress = RunProgress(bar, self._end / 1e9)

    def start(self, *names: str) -> None:
        """Start nodes in one process, paused."""
        arguments = ['--ros-args', '--params-file', str(self._output / 'parameters.yaml'), '-p', 'paused:=true']
        if self._namespace != '/':
            arguments += ['-r', f'__ns:={self._namespace}']
        self.processes.append(NodeProcess(names, arguments, self._output / 'log' / f'{"_".join(names)[:60]}.log'))

    def spin_until(self, condition: Callable[[], Any], seconds: float) -> bool:
        """Spin until a condition holds; False when time is up or the run is over."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline or self.is_over():
                return False
            self._turn()
        return True

    def resume(self) -> None:
        """Ask the paused plant to resume, until it has accepted."""
        deadline = time.monotonic() + self.patience
        while not self.spin_until(self.recorder.resume(self._period if self.lockstep else 0).done, 1.0):
            if time.monotonic() > deadline or self.is_over():
                return

    def drain(self) -> None:
        """Record messages that have arrived and are not recorded yet."""
        self.recorder.drain(self._turn, 0.3, _BEHIND)

    def is_over(self) -> bool:
        """Return whether a stop is requested, a process has ended, or nothing more can be recorded."""
        return (self._stop.requested or bool(self._bag.failure or self.recorder.law_failure)
                or any(process.exit_code() is not None for process in self.processes))

    def is_at(self, stamp: int) -> bool:
        """Return whether the newest message on every loop topic has a stamp [ns]."""
        return all(self.recorder.newest.get(topic) == stamp for topic in self.loop.topics)

    def watch(self, done: Callable[[], bool] = lambda: False) -> None:
        """Spin and move the progress bar until a condition holds, the run is over, or nothing moves."""
        newest, moved, looked = -1, time.monotonic(), 0.0
        start = 0 if self.lockstep else self.recorder.newest.get('joint_states', 0)
        while not self.is_over() and not done():
            self._turn()
            if time.monotonic() > looked + SETTLE:
                looked = time.monotonic()
                refuse_other_publishers(self.recorder.topics_of_others(ours=1))
            now = self._reached()
            if now != newest:
                newest, moved = now, time.monotonic()
                self._progress.show((newest - start) / 1e9, least=0.05)
            elif time.monotonic() - moved > self.patience:
                break
        if self.recorder.law_failure:
            self._see_standstill()
        self._progress.show((self._reached() - start) / 1e9)
        self._bar.refresh()

    def _see_standstill(self) -> None:
        """Record the first command after a failure of the law; the plant may still wait for it."""
        end, deadline = self._reached() + AHEAD * self._period + self._position_period, time.monotonic() + _STANDSTILL
        while (self._reached() < end and time.monotonic() < deadline and not self._stop.requested
               and all(process.exit_code() is None for process in self.processes)):
            self._turn()

    def _reached(self) -> int:
        """Return the stamp that the run has reached: on the wall clock, that of the slowest topic."""
        newest = self.recorder.newest
        return newest['joint_states'] if self.lockstep else min(newest.get(topic, -1) for topic in self.loop.topics)

    def result(self) -> ExperimentResult:
        """Return how the run ended."""
        if self._stop.requested or self._bag.failure:
            return ExperimentResult('interrupted', '')
        if self.recorder.law_failure:
            return ExperimentResult('law_failed', self.recorder.law_failure)
        for process in self.processes:
            if process.exit_code() == 0 and 'plant' in process.name:
                return ExperimentResult('completed', '')
            if process.exit_code() == 1 and 'plant' in process.name:
                return ExperimentResult('diverged', process.exit_report())
        dead = [process for process in self.processes if process.exit_code() is not None]
        if dead:
            return ExperimentResult('node_died', '\n'.join(process.exit_report() for process in dead))
        # one that was suspended while it published may have answered the recorder and not the other nodes
        suspended = [process.name for process in self.processes if is_suspended(process.pid)]
        silent = ', '.join(suspended) or silent_node(
            self.recorder.newest, self.lockstep, self._position_period, self.loop)
        return ExperimentResult('node_died', f'{silent} gave no answer for {self.patience} s and was given up')


def run_experiment(
    parameters: Configuration, output: Path, namespace: str, composed: bool, patience: float, stop: Stop, bar: tqdm,
    supervisor: Supervisor, course: Procedure | None = None,
) -> ExperimentResult:
    """
    Run an experiment and record it into a folder with `parameters.yaml`; the bag and the nodes' logs are added there.

    The run is given up after `patience` seconds of wall time without progress; the bar shows its simulated time. The
    bag is complete, or readable up to its end. Raises ParameterError if another node publishes on the topics. rclpy
    stays initialised: leaving DDS may hang, and the run must be evaluated before.
    """
    use_fastdds_profiles(output / 'log')
    begun = False
    shut_down()  # of a previous run
    try:
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        with BagWriter(output / 'bag') as bag:
            recorder = Recorder(namespace, bag.write, bag.knows, loop_of(parameters.plant))
            keep_node(recorder)
            executor = make_executor()
            executor.add_node(recorder)

            def turn() -> None:
                executor.spin_once(timeout_sec=0.05)
                supervisor.note_progress()

            runner = ExperimentRunner(
                parameters=parameters, output=output, namespace=namespace, patience=patience, stop=stop,
                recorder=recorder, turn=turn, bag=bag, bar=bar)
            runner.spin_until(recorder.topics_of_others, SETTLE)
            refuse_other_publishers(recorder.topics_of_others())
            begun = True
            if course is not None:
                executor.add_node(course.attach(namespace))
            try:
                for names in [runner.loop.nodes] if composed else [(name,) for name in runner.loop.nodes]:
                    runner.start(*names)
                    supervisor.note_node(runner.processes[-1].pid)
                # the paused plant repeats its first messages until they and every answer to them have been recorded
                ready = recorder.has_every_node if runner.lockstep else recorder.all_discovered
                if runner.spin_until(ready, max(patience, START)):
                    if course is not None:
                        course.follow(runner)
                    runner.resume()
                    runner.watch()
                result = runner.result()
            except RunFailedError as error:
                result = ExperimentResult('interrupted', str(error))
            finally:
                stop_processes(runner.processes)
                runner.drain()
        if result.outcome == 'completed' and recorder.law_failure:  # reported at the very end
            result = ExperimentResult('law_failed', recorder.law_failure)
        return result._replace(reason='\n'.join(filter(None, (result.reason, bag.failure))))
    except (RuntimeError, MemoryError) as error:
        if isinstance(error, RCLError) and not begun:
            raise ParameterError([f'ROS 2 cannot start: {one_line(error)}; check the ROS_* environment variables']
                                 ) from error
        return ExperimentResult('node_died', f'ROS 2: {one_line(error)}; the machine or its limits (ulimit) may leave '
                                'too little room')
