"""One experiment from its first process to its last: the runner of the nodes, a recorder in DDS and a bag."""

from pathlib import Path

import rclpy
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.configuration.nodes import Configuration, loop_of
from mobile_robot_control.experiment.fastdds_profiles import use_fastdds_profiles
from mobile_robot_control.experiment.node_processes import START, stop_processes
from mobile_robot_control.experiment.result import ExperimentResult, RunFailedError
from mobile_robot_control.experiment.runner import SETTLE, Course, ExperimentRunner, refuse_other_publishers
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.recording.bag_writer import BagWriter
from mobile_robot_control.ros.nodes.recorder import Recorder
from mobile_robot_control.ros.services.stop import Stop
from mobile_robot_control.ros.spin import RCLError, make_executor, one_line
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.supervisor import Supervisor, keep_node, shut_down


def run_experiment(
    parameters: Configuration, output: Path, namespace: str, composed: bool, patience: float, stop: Stop, bar: tqdm,
    supervisor: Supervisor, course: Course | None = None,
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

            runner = ExperimentRunner(parameters, output, namespace, patience, stop, recorder, turn, bag, bar)
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
