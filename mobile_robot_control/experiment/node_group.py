"""The processes of a run, ours and somebody else's: in which order they start, and how they end."""

import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from rcl_interfaces.msg import ParameterType

from mobile_robot_control.experiment.foreign_nodes import ForeignNode, ours
from mobile_robot_control.experiment.node_processes import NodeProcess, stop_processes
from mobile_robot_control.experiment.recorder import Recorder
from mobile_robot_control.topics import LoopGraph

SETTLE = 1.0
"""[s] of wall time for finding other publishers, before a run and repeatedly during it."""
_TRIES = 3
"""Of a question of DDS, whose answer may be lost while nodes discover each other."""
_STANDING = 40.0
"""[s] of wall time, at most, until an attached robot stands and its process of zero commands has ended."""
_Note = Callable[[int], None]
_Wait = Callable[[Callable[[], bool], float], bool]


class NodeGroup:
    """
    The processes of one run.

    DDS discovery takes up to seconds, and a run must not begin before its recorder receives all of it: nodes start
    `paused`. A plant of somebody else may run as soon as it is answered. In lockstep it is started last, while the node
    of the last answer is suspended: the run begins when that goes on, recorded from its first message. Beside a plant
    that runs already the cart is started last, since nothing moves without a reference.

    Parameters
    ----------
    output : Path
        Folder with `parameters.yaml`.
    namespace : str
        Of the nodes.
    nodes : mapping of str to ForeignNode
        Those of somebody else.
    loop : LoopGraph
        With the topics that nodes wait for.
    lockstep : bool
        Whether simulated time waits for every node.
    recorder : Recorder
        Hears them.
    duration : int
        Of the run [ns].

    Attributes
    ----------
    processes : list of NodeProcess
        Of the nodes.
    flow_control : bool
        Whether the plant can be paused and held.
    begun : int
        First stamp of a run in lockstep [ns].

    """

    def __init__(
        self, output: Path, namespace: str, nodes: Mapping[str, ForeignNode], loop: LoopGraph, lockstep: bool,
        recorder: Recorder, duration: int,
    ) -> None:
        self.processes: list[NodeProcess] = []
        self.flow_control = 'plant' not in nodes
        self.begun, self._duration = 0, duration
        self._stopper: NodeProcess | None = None
        self._output, self._namespace, self._nodes = output, namespace, nodes
        self._loop, self._lockstep, self._recorder = loop, lockstep, recorder

    def start(self, composed: bool, note: _Note, wait: _Wait, seconds: float) -> None:
        """
        Start all nodes that do not run already, paused.

        Parameters
        ----------
        composed : bool
            Whether ours are in one process.
        note : callable
            Takes the number of each process.
        wait : callable
            Waits for a condition, for a wall time [s]; returns whether it holds.
        seconds : float
            Wall time for nodes to start.

        """
        mine = ours(self._loop, self._nodes)
        groups = [mine] if composed and mine else [[name] for name in mine]
        groups += [[name] for name, node in self._nodes.items() if not node.is_attached]
        plant, last = self._nodes.get('plant'), 'plant'
        if plant is not None and plant.is_attached:
            last = 'reference_cart'
            self._watch_robot()
        is_late = [last] in groups and plant is not None and (self._lockstep or plant.is_attached)
        for names in [names for names in groups if not (is_late and names == [last])]:
            note(self._started(*names))
        if is_late and not wait(lambda: self._recorder.all_discovered(but=last), seconds):
            return
        late = [last] if is_late else []
        if plant is not None and self._lockstep:
            self._begin_in_lockstep(late, note, wait, seconds)
        elif plant is not None:
            self._begin_on_the_wall_clock(late, note, wait, seconds)

    def _started(self, *names: str) -> int:
        """Start nodes in one process, or one of somebody else; return the number of the process."""
        words = self._nodes[names[0]].words if names[0] in self._nodes else ()
        arguments = ['--ros-args', '--params-file', str((self._output / 'parameters.yaml').resolve())]
        arguments += ['-r', f'__node:={names[0]}'] if words else []
        arguments += [] if words and names != ('plant',) else ['-p', 'paused:=true']
        if self._namespace != '/':
            arguments += ['-r', f'__ns:={self._namespace}']
        log = self._output / 'log' / f'{"_".join(names)[:60]}.log'
        self.processes.append(NodeProcess(names, arguments, log, words))
        return self.processes[-1].pid

    def _begin_in_lockstep(self, late: Sequence[str], note: _Note, wait: _Wait, seconds: float) -> None:
        """Start the last node beside a plant of somebody else, which nothing answers before the recorder hears both."""
        # somebody else's nodes do not tell who listens to them
        if len(self._nodes) > 1:
            wait(lambda: False, SETTLE)
        answering = [process for process in self.processes
                     if self._loop.topics[self._loop.command].publisher in process.name]
        for process in answering:
            process.signal(signal.SIGSTOP)
        try:
            for name in late:
                note(self._started(name))
            if wait(lambda: all(map(self._recorder.hears, {'plant', *late})), seconds):
                self.begun = self._recorder.newest[self._loop.clock]
                self._recorder.last = self.begun + self._duration
                self._find_flow_control(wait)
        finally:
            for process in answering:
                process.signal(signal.SIGCONT)

    def _begin_on_the_wall_clock(self, late: Sequence[str], note: _Note, wait: _Wait, seconds: float) -> None:
        """Find the plant of somebody else, and start the last node beside a robot, whose run begins with it."""
        if not self._nodes['plant'].is_attached:
            # as long as it is paused it is silent
            if wait(lambda: self._recorder.hears('plant') or self._recorder.serves_parameters(), seconds):
                self._find_flow_control(wait)
        elif wait(lambda: self._recorder.hears('plant'), seconds):
            for name in late:
                note(self._started(name))
            wait(lambda: self._recorder.hears('reference_cart'), seconds)

    def _find_flow_control(self, wait: _Wait) -> None:
        """Find out whether a plant of somebody else can be held: it may lack the parameters, or serve none."""
        if not wait(self._recorder.serves_parameters, SETTLE):
            return
        for _ in range(_TRIES):
            answer = self._recorder.ask_for_flow_control()
            if wait(answer.done, SETTLE):
                kinds = [value.type for value in answer.result().values]
                self.flow_control = kinds == [ParameterType.PARAMETER_BOOL, ParameterType.PARAMETER_DOUBLE]
                return

    def _watch_robot(self) -> None:
        """Start the process that stops an attached robot when the run ends, or this process does."""
        # in lockstep nothing moves without an answer
        if not self._lockstep:
            self._stopper = NodeProcess(
                ['stopper'], [str(self._output.resolve()), self._namespace], self._output / 'log' / 'stopper.log',
                [sys.executable, '-m', 'mobile_robot_control.experiment.stopping_process'])

    def ended(self) -> list[NodeProcess]:
        """List the processes that have ended."""
        return [process for process in (*self.processes, *filter(None, [self._stopper]))
                if process.exit_code() is not None]

    def end(self) -> str:
        """End all nodes, and stop an attached robot; return why that is not sure."""
        if self._stopper is not None:
            self._stopper.close_input()
        stop_processes(self.processes)
        if self._stopper is None:
            return ''
        self._stopper.wait_or_kill(_STANDING)
        return '' if self._stopper.exit_code() == 0 else self._stopper.exit_report()
