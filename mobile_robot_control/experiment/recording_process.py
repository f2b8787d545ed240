"""
Record the topics of a namespace until the standard input closes; then measure and draw the run.

The first line on the standard output says that it records, or why it does not.
"""

import sys
import time
from pathlib import Path

import rclpy
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.experiment.evaluation import evaluate
from mobile_robot_control.experiment.recorder import NO_LIMIT, Recorder
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.ros.shared.process import Stop
from mobile_robot_control.ros.start.spin import make_executor
from mobile_robot_control.runs.new_bag import BagWriter
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import loop_of
from mobile_robot_control.system.files import explain
from mobile_robot_control.system.supervisor import keep_node, leave_dds
from mobile_robot_control.topics import LOOPS, LoopGraph

_DISCOVERY = 8.0
"""[s] of wall time without a further topic, at most, until all are discovered; DDS repeats what was lost every 3 s."""
_BEHIND, _SILENT = 10.0, 0.5
"""[s] of wall time: at most until every topic is recorded to the end, and without a message of the loop."""


def record(folder: Path, namespace: str, stop: Stop) -> int:
    """Record into a folder that has `parameters.yaml` until a stop is requested; return the exit code."""
    try:
        loop = loop_of(configure(load([folder / 'parameters.yaml'], namespace=namespace)).plant)
    except ParameterError as error:
        # nodes are recorded even if their parameters are unknown to this process, such as a law of their own
        print(f'{folder / "parameters.yaml"}: {error}')
        loop = LOOPS['torque']
    try:
        failure = _record_bag(folder / 'bag', namespace, stop, loop)
    except OSError as error:
        failure = explain(error)
    evaluated = evaluate(folder, namespace, 'recorded', f'dashboard --namespace {namespace}', quiet=True)
    # the page shows the last line
    for line in filter(None, (*evaluated.unwritten, failure)):
        print(line)
    return 1 if failure or evaluated.unwritten else 0


def _record_bag(path: Path, namespace: str, stop: Stop, loop: LoopGraph) -> str:
    """Record a bag until a stop is requested; return the write error, '' if there was none."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    with BagWriter(path) as bag:
        recorder = Recorder(namespace, bag.write, bag.knows, loop)
        keep_node(recorder)
        executor = make_executor()
        executor.add_node(recorder)
        # topics are discovered one after the other: the recording begins at one stamp for all of them
        recorder.first = NO_LIMIT
        deadline, heard = time.monotonic() + _DISCOVERY, 0
        while not recorder.has_every_topic() and time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.05)
            if len(recorder.newest) > heard:
                deadline, heard = time.monotonic() + _DISCOVERY, len(recorder.newest)
        recorder.first = max(recorder.newest.values(), default=0)
        print('recording', flush=True)
        while not stop.requested and not bag.failure:
            executor.spin_once(timeout_sec=0.05)
        # topics come from several processes: on a busy machine the messages of one may be late
        recorder.last = max(recorder.newest.values(), default=0)
        recorder.drain(lambda: executor.spin_once(timeout_sec=0.05), _SILENT, _BEHIND, recorder.is_complete)
    return bag.failure


if __name__ == '__main__':
    stopping = Stop()
    stopping.follow_parent()
    sys.exit(leave_dds(record(Path(sys.argv[1]), sys.argv[2], stopping)))
