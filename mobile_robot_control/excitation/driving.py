"""One excitation from its first message to its last; at the end the robot is always stopped."""

import sys
import time
from contextlib import ExitStack
from pathlib import Path

import rclpy
from rclpy.executors import Executor
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.excitation.excitation import Area, Excitation
from mobile_robot_control.excitation.exciter import Exciter
from mobile_robot_control.excitation.request import ExcitationRequest
from mobile_robot_control.experiment.node_group import SETTLE
from mobile_robot_control.experiment.stopping import send_zeros
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.ros.shared.process import Stop
from mobile_robot_control.ros.shared.qos import flush
from mobile_robot_control.ros.shared.timers import create_steady_timer
from mobile_robot_control.ros.start.spin import make_executor
from mobile_robot_control.runs.bag import topic_names
from mobile_robot_control.runs.new_bag import BagWriter
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.supervisor import keep_node

_PATIENCE = 20.0
"""[s] of wait for odometry and the robot's subscription."""
_TURN = 0.02
"""[s]"""
_LEAST = (0.01, 0.05)
"""[m], [rad]: a robot with less motion has not followed."""


def excite_robot(request: ExcitationRequest, area: Area, stop: Stop) -> Excitation:
    """
    Drive a robot until the duration is over, a stop is requested or a fault occurs; then send zero commands.

    Raises
    ------
    ParameterError
        If nothing was commanded: no odometry, no robot that takes commands, or others that command it.
    """
    shared = request.sources.configuration(request.namespace).plant.shared
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    with ExitStack() as stack:
        bag: list[BagWriter] = []

        def record(topic: str, kind: str, received: int, message: bytes) -> None:
            for writer in bag:
                writer.write(topic, kind, received, message)
                exciter.fault = exciter.fault or writer.failure

        exciter = Exciter(request.namespace, topic_names(request.topic), area, shared.stamped_cmd_vel,
                          shared.base_frame_id, shared.stamp_tolerance, record)
        keep_node(exciter)
        executor = make_executor()
        executor.add_node(exciter)
        _wait_for(exciter, executor, stop)
        if request.bag:
            bag.append(stack.enter_context(BagWriter(Path(request.bag))))
        try:
            _drive(exciter, executor, stop, request)
        finally:
            _stop(exciter, executor, request.rate)
        fault = exciter.fault or 'interrupted' * stop.requested
    # the end of the bag may fail, too
    fault = fault or ''.join(writer.failure for writer in bag)
    if not fault and exciter.way < _LEAST[0] and exciter.turn < _LEAST[1]:
        fault = 'the robot has not moved: is it switched on and released, and are the commands large enough'
    return Excitation(exciter.way, exciter.turn, exciter.farthest, fault)


def _wait_for(exciter: Exciter, executor: Executor, stop: Stop) -> None:
    """Wait for the robot; raise ParameterError if it is missing, or others command it."""
    deadline = time.monotonic() + _PATIENCE
    settled, told = time.monotonic() + SETTLE, False
    while ((exciter.missing() and time.monotonic() < deadline) or time.monotonic() < settled) and not stop.requested:
        executor.spin_once(timeout_sec=_TURN)
        if exciter.missing() and time.monotonic() > settled and not told:
            told = True
            print(f'excite: waiting: {exciter.missing()}', file=sys.stderr)
    others = exciter.others()
    refusal = exciter.missing() or (others and f'{others} commands the robot already: stop it')
    if stop.requested or refusal:
        raise ParameterError(['interrupted, the robot was not moved' if stop.requested else refusal])


def _drive(exciter: Exciter, executor: Executor, stop: Stop, request: ExcitationRequest) -> None:
    exciter.begin()
    timer = create_steady_timer(1.0 / request.rate, exciter.step, exciter)
    began = time.monotonic()
    with tqdm(total=request.duration, desc='excite', disable=None, leave=False,
              bar_format='{l_bar}{bar}| {n:.0f}/{total:.0f} s') as bar:
        while (passed := time.monotonic() - began) < request.duration and not (stop.requested or exciter.fault):
            executor.spin_once(timeout_sec=_TURN)
            bar.update(passed - bar.n)
    exciter.destroy_timer(timer)


def _stop(exciter: Exciter, executor: Executor, rate: float) -> None:
    send_zeros(exciter, exciter.stop, exciter.stands, executor, rate)
    flush(exciter.publisher)
