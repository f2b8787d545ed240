"""Start nodes, spin them, stop them: the one spin loop."""

import gc
import importlib
import sys
from collections.abc import Sequence
from typing import Any

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.parameters import ParameterError
from mobile_robot_control.ros.arguments import check
from mobile_robot_control.ros.deadline import exit_after
from mobile_robot_control.ros.executables import Stop

_LEAVING = 5
"""[s] that the nodes of a process have to leave DDS."""
_CLASSES = {
    'plant': 'Plant',
    'velocity_controller': 'VelocityController',
    'position_controller': 'PositionController',
    'reference_cart': 'ReferenceCart',
}


def make_executor() -> Executor:
    """
    Make the fastest executor there is.

    Returns
    -------
    Executor
        rclpy's EventsExecutor; the single-threaded one where rclpy has none yet.

    """
    try:
        from rclpy.experimental.events_executor import EventsExecutor  # noqa: PLC0415 (absent before jazzy)
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()


def _make(name: str) -> Any:
    module = importlib.import_module(f'mobile_robot_control.ros.{name}')
    return getattr(module, _CLASSES[name])()


def spin(names: Sequence[str], arguments: Sequence[str], stop: Stop) -> int:
    """
    Start nodes and spin them until one is done or a stop is asked for.

    Parameters
    ----------
    names : sequence of str
        Node names.
    arguments : sequence of str
        ROS arguments.
    stop : Stop
        The request to end.

    Returns
    -------
    int
        Exit code: 0 done or stopped, 1 the run failed, 2 refused configuration.

    """
    who = ' '.join(names)
    try:
        check(names, arguments)
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    except ParameterError as error:
        return _refuse(who, error.violations)
    except Exception as error:  # rclpy raises bare RCLError for whatever rcl cannot parse
        return _refuse(who, [str(error)])
    nodes: list[Any] = []
    code = 1
    try:
        for name in names:
            nodes.append(_make(name))
        code = _spin(nodes, stop)
    except ParameterError as error:
        code = _refuse(who, error.violations)
    except ParameterException as error:  # a parameter of ROS's own, such as use_sim_time: 3
        code = _refuse(who, [str(error)])
    finally:
        # where many processes end at once Fast DDS may deadlock: https://github.com/eProsima/Fast-DDS/issues/6502
        with exit_after(_LEAVING, code):
            for node in nodes:
                node.destroy_node()
            rclpy.try_shutdown()
    return code


def _refuse(who: str, violations: Sequence[str]) -> int:
    for violation in violations:
        print(f'{who}: {violation}', file=sys.stderr)
    return 2


def _spin(nodes: Sequence[Any], stop: Stop) -> int:
    executor = make_executor()
    for node in nodes:
        executor.add_node(node)
    # what was made up to here stays: looking through it for garbage would hold the loop up
    gc.freeze()
    # EventsExecutor.spin() never returns on a signal: short turns look at the flag
    while not stop.requested and all(node.exit_code is None for node in nodes):
        executor.spin_once(timeout_sec=0.1)
    for node in nodes:
        node.close()
    gc.unfreeze()
    # lets go of every callback while the nodes are there
    executor.shutdown()
    return max(node.exit_code or 0 for node in nodes)
