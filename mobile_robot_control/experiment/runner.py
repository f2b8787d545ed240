"""The experiment runner: it starts the nodes of a run, records, and watches them to the end."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.experiment.conduct import Conduct
from mobile_robot_control.experiment.foreign_nodes import ForeignNode
from mobile_robot_control.experiment.node_group import SETTLE, NodeGroup
from mobile_robot_control.experiment.node_processes import START, use_fastdds_profiles
from mobile_robot_control.experiment.recorder import AHEAD, Recorder
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import period_nanoseconds
from mobile_robot_control.ros.shared import conversions
from mobile_robot_control.ros.shared.process import Stop
from mobile_robot_control.ros.start.spin import RCLError, make_executor, one_line
from mobile_robot_control.runs.new_bag import BagWriter
from mobile_robot_control.settings.nodes import Configuration, loop_of
from mobile_robot_control.system.progress import RunProgress, tqdm
from mobile_robot_control.system.supervisor import Supervisor, is_suspended, keep_node, shut_down
from mobile_robot_control.topics import ALL_LOOP_TOPICS, required, silent_node


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
    flow_control : bool
        Whether the recorder could hold the plant; only one of somebody else's may lack it.

    """

    outcome: str
    reason: str
    flow_control: bool = True


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
        turn: Callable[[], None], bag: BagWriter, bar: tqdm, nodes: Mapping[str, ForeignNode],
    ) -> None:
        self._nodes = nodes
        self.recorder, self.patience = recorder, patience
        self._stop, self._turn, self._bag, self._bar = stop, turn, bag, bar
        shared, self.loop = parameters.plant.shared, required(loop_of(parameters.plant), nodes)
        self.lockstep = shared.lockstep
        self._period = period_nanoseconds(shared.velocity_rate)
        self._end = round(parameters.plant.duration * shared.velocity_rate) * self._period
        self._position_period = period_nanoseconds(shared.position_rate)
        self.group = NodeGroup(output, namespace, nodes, self.loop, self.lockstep, recorder,
                               self._end)
        self._progress = RunProgress(bar, self._end / 1e9)
        # between these stamps the plant has begun the run; on the wall clock it moves before its answer arrives
        self._earliest = self._start = 0

    def start(self, composed: bool, note: Callable[[int], None]) -> None:
        """Start all nodes that do not run already, paused; `note` takes the number of each process."""
        self.group.start(composed, note, self.spin_until, self.starting)

    @property
    def starting(self) -> float:
        """Wall time for nodes to start [s]."""
        return max(self.patience, START)

    def is_ready(self) -> bool:
        """Return whether the run can begin without that a message is missed."""
        if self.lockstep:
            return self.recorder.has_every_node()
        plant = self._nodes.get('plant')
        return self.recorder.has_every_topic() if plant and plant.is_attached else self.recorder.all_discovered()

    def spin_until(self, condition: Callable[[], Any], seconds: float) -> bool:
        """Spin until a condition holds; False when time is up or the run is over."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline or self.is_over():
                return False
            self._turn()
        return True

    def resume(self) -> None:
        """Ask the paused plant to resume, until it has accepted; one that cannot be paused runs already."""
        if not self.group.flow_control:
            return
        if self._nodes:
            # what somebody else's node publishes for recordings alone; none waits for it
            self.spin_until(self.recorder.hears_optional, SETTLE)
        if not self.lockstep:
            self._earliest = self.recorder.newest.get(self.loop.clock, 0)
        deadline = time.monotonic() + self.patience
        while not self.spin_until(self.recorder.resume(self._period if self.lockstep else 0).done, 1.0):
            if time.monotonic() > deadline or self.is_over():
                return

    def drain(self) -> None:
        """Record messages that have arrived and are not recorded yet."""
        # what runs already goes on
        is_attached = any(node.is_attached for node in self._nodes.values())
        self.recorder.drain(self._turn, 0.3, SETTLE if is_attached else _BEHIND)

    def is_over(self) -> bool:
        """Return whether a stop is requested, a process has ended, or nothing more can be recorded."""
        return (self._stop.requested or bool(self._bag.failure or self.recorder.law_failure or self.recorder.fault)
                or bool(self.group.ended()))

    def is_at(self, stamp: int) -> bool:
        """Return whether the newest message on every loop topic has a stamp [ns]."""
        return all(self.recorder.newest.get(topic) == stamp for topic in self.loop.topics)

    def watch(self, done: Callable[[], bool] = lambda: False) -> None:
        """Spin and move the progress bar until a condition holds, the run is over, or nothing moves."""
        newest, moved, looked = -1, time.monotonic(), 0.0
        plant = self._nodes.get('plant')
        if plant and not self.lockstep:
            self.spin_until(lambda: self.loop.clock in self.recorder.newest, self.patience)
        start = self._start = self.group.begun if self.lockstep else self.recorder.newest.get(self.loop.clock, 0)
        if plant and plant.is_attached:
            self.recorder.last = start + self._end
        while not self.is_over() and not done() and not self._is_at_end(start):
            self._turn()
            if time.monotonic() > looked + SETTLE:
                looked = time.monotonic()
                self._refuse_others()
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

    def _refuse_others(self) -> None:
        others = self.recorder.topics_of_others(ours=1)
        if others and self._nodes:
            raise RunFailedError(
                f'{others[0]} has several publishers, {self.recorder.publishers(others[0])}; one is enough')
        refuse_other_publishers(others)

    def _is_at_end(self, start: int) -> bool:
        """Return whether a plant of somebody else, which may know no duration, is answered to the end from a start."""
        if 'plant' not in self._nodes:
            return False
        newest, end = self.recorder.newest, start + self._end
        if not self.lockstep:
            return start > 0 and newest.get(self.loop.clock, start) >= end
        tick = end - end % self._position_period
        return all(newest.get(name, -1) >= (end if topic.rate == 'velocity_rate' else tick)
                   for name, topic in self.loop.topics.items())

    def _see_standstill(self) -> None:
        """Record the first command after a failure of the law; the plant may still wait for it."""
        end, deadline = self._reached() + AHEAD * self._period + self._position_period, time.monotonic() + _STANDSTILL
        while (self._reached() < end and time.monotonic() < deadline and not self._stop.requested
               and not self.group.ended()):
            self._turn()

    def _reached(self) -> int:
        """Return the stamp that the run has reached: on the wall clock, that of the slowest topic."""
        newest = self.recorder.newest
        if self.lockstep:
            return newest.get(self.loop.clock, 0)
        return min(newest.get(topic, -1) for topic in self.loop.topics)

    def result(self) -> ExperimentResult:
        """Return how the run ended."""
        if self._stop.requested or self._bag.failure:
            ended = 'interrupted', ''
        elif self.recorder.law_failure:
            ended = 'law_failed', self.recorder.law_failure
        else:
            if self._nodes and self.group.ended():
                # what it has published before its end; others may go on
                self.recorder.drain(self._turn, 0.3, SETTLE)
            ended = ('node_died', self.recorder.fault) if self.recorder.fault else self._end_of_nodes()
        return ExperimentResult(*ended, self.group.flow_control or not self.lockstep)

    def _end_of_nodes(self) -> tuple[str, str]:
        """Return outcome and reason of a run that nobody has interrupted."""
        if self._is_at_end(self._earliest or self._start):
            return 'completed', ''
        for process in self.group.processes:
            if not process.is_foreign and 'plant' in process.name and process.exit_code() in (0, 1):
                return ('diverged', process.exit_report()) if process.exit_code() else ('completed', '')
        dead = self.group.ended()
        if dead:
            return 'node_died', '\n'.join(process.exit_report() for process in dead)
        # one that was suspended while it published may have answered the recorder and not the other nodes
        suspended = [process.name for process in self.group.processes if is_suspended(process.pid)]
        silent = ', '.join(suspended) or self.recorder.ahead() or silent_node(
            self.recorder.newest, self.lockstep, self._position_period, self.loop)
        told = f'; {self.recorder.description(silent)}' if silent in self._nodes else ''
        return 'node_died', f'{silent} gave no answer for {self.patience} s and was given up{told}'


def _conduct(parameters: Configuration, nodes: Mapping[str, ForeignNode]) -> dict[str, Conduct]:
    """Return the judges of the topics of somebody else's nodes."""
    shared = parameters.plant.shared
    return {name: Conduct(name, conversions.reader(name, shared), period_nanoseconds(getattr(shared, topic.rate)),
                          shared.lockstep)
            for name, topic in loop_of(parameters.plant).topics.items()
            if topic.publisher in nodes and name in ALL_LOOP_TOPICS}


def run_experiment(
    parameters: Configuration, output: Path, namespace: str, composed: bool, patience: float, stop: Stop, bar: tqdm,
    supervisor: Supervisor, course: Procedure | None = None, nodes: Mapping[str, ForeignNode] | None = None,
) -> ExperimentResult:
    """
    Run an experiment and record it into a folder with `parameters.yaml`; the bag and the nodes' logs are added there.

    The run is given up after `patience` seconds of wall time without progress; the bar shows its simulated time. The
    bag is complete, or readable up to its end. Nodes of somebody else, by name, take the places of ours. Raises
    ParameterError if another node publishes on the topics. rclpy stays initialised: leaving DDS may hang, and the run
    must be evaluated before.
    """
    use_fastdds_profiles(output / 'log')
    begun, nodes = False, nodes or {}
    shut_down()  # of a previous run
    try:
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        with BagWriter(output / 'bag') as bag:
            recorder = Recorder(namespace, bag.write, bag.knows, loop_of(parameters.plant), _conduct(parameters, nodes),
                                [name for name, node in nodes.items() if node.is_attached])
            keep_node(recorder)
            executor = make_executor()
            executor.add_node(recorder)

            def turn() -> None:
                executor.spin_once(timeout_sec=0.05)
                supervisor.note_progress()

            runner = ExperimentRunner(
                parameters=parameters, output=output, namespace=namespace, patience=patience, stop=stop,
                recorder=recorder, turn=turn, bag=bag, bar=bar, nodes=nodes)
            runner.spin_until(recorder.topics_of_others, SETTLE)
            refuse_other_publishers(recorder.topics_of_others())
            begun = True
            if course is not None:
                executor.add_node(course.attach(namespace))
            try:
                runner.start(composed, supervisor.note_node)
                # the paused plant repeats its first messages until they and every answer to them have been recorded
                if runner.spin_until(runner.is_ready, runner.starting):
                    if course is not None:
                        course.follow(runner)
                    runner.resume()
                    runner.watch()
                result = runner.result()
            except RunFailedError as error:
                result = ExperimentResult('interrupted', str(error), runner.result().flow_control)
            finally:
                unsure = runner.group.end()
                runner.drain()
        if result.outcome == 'completed' and recorder.law_failure:  # reported at the very end
            result = ExperimentResult('law_failed', recorder.law_failure)
        return result._replace(reason='\n'.join(filter(None, (result.reason, bag.failure, unsure))))
    except (RuntimeError, MemoryError) as error:
        if isinstance(error, RCLError) and not begun:
            raise ParameterError([f'ROS 2 cannot start: {one_line(error)}; check the ROS_* environment variables']
                                 ) from error
        return ExperimentResult('node_died', f'ROS 2: {one_line(error)}; the machine or its limits (ulimit) may leave '
                                'too little room')
