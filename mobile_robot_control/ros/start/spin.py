"""Start, spin and end nodes: the one spin loop."""

import gc
import os
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import rclpy
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.executors import Executor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.ros.shared.process import LOAD_ERRORS, Stop, load_fault, refuse
from mobile_robot_control.ros.start.arguments import check_ros_arguments
from mobile_robot_control.ros.start.loaded import load
from mobile_robot_control.system.supervisor import LEAVING, exit_after

RCLError = rclpy_implementation.RCLError
"""Raised by rclpy if rcl refuses."""
_SWITCHES = 0.0005
"""[s] for which a thread of Python may keep the others waiting."""


def one_line(error: BaseException) -> str:
    """Return the text of an error of rclpy in one line."""
    return ' '.join(str(error).split()) or type(error).__name__


def make_executor() -> Executor:
    """Make rclpy's EventsExecutor, which is faster than the default one."""
    return EventsExecutor()


def spin(names: Sequence[str], arguments: Sequence[str], stop: Stop, own: object = None) -> int:
    """
    Start nodes and spin them until one is done or a stop is requested.

    Parameters
    ----------
    names : sequence of str
        Node names.
    arguments : sequence of str
        ROS arguments.
    stop : Stop
        The request to end.
    own : OwnNode or None
        Run this node instead of the four.

    Returns
    -------
    int
        Exit code: 0 done or stopped, 1 the run failed, 2 refused configuration.

    """
    label = ' '.join(names)
    # another DDS does not read it; a user's own file stays in force, by its former name too
    if 'FASTRTPS_DEFAULT_PROFILES_FILE' not in os.environ:
        os.environ.setdefault('FASTDDS_DEFAULT_PROFILES_FILE', str(Path(__file__).with_name('fastdds.xml')))
    try:
        of_cart = {} if own is not None else check_ros_arguments(names, arguments)
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    except ParameterError as error:
        return refuse(label, error.violations)
    except Exception as error:  # rclpy raises bare RCLError for anything that rcl cannot parse
        return refuse(label, [one_line(error)])
    nodes: list[Any] = []
    code = 1
    try:
        for name in names:
            make_node = load(name if own is None else 'own_node')
            nodes.append(make_node(own) if own is not None else
                         make_node(of_cart) if name == 'reference_cart' else make_node())
    except ParameterError as error:
        code = refuse(label, error.violations)
    except ParameterException as error:  # a parameter of ROS's own, such as use_sim_time: 3
        code = refuse(label, [str(error)])
    except (RCLError, NameValidationException) as error:  # names, topics and peers given to ROS
        code = refuse(label, [f'{one_line(error)}; check the remappings (-r) and the ROS_* environment variables'])
    except LOAD_ERRORS as error:
        refuse(label, [load_fault(error)])
    except RuntimeError as error:  # no threads are left
        print(f'{label}: {one_line(error)}; the machine or its limits (ulimit) leave too little room', file=sys.stderr)
    else:
        code = _spin(nodes, stop)
    finally:
        # where many processes end at once Fast DDS may deadlock: https://github.com/eProsima/Fast-DDS/issues/6502
        with exit_after(LEAVING, code):
            for node in nodes:
                node.destroy_node()
            rclpy.try_shutdown()
    return code


def _spin(nodes: Sequence[Any], stop: Stop) -> int:
    executor = make_executor()
    for node in nodes:
        executor.add_node(node)
    # the objects made so far stay: collecting garbage among them would delay the loop
    gc.freeze()
    # a thread that checks a live change must not delay a tick by Python's 5 ms
    sys.setswitchinterval(_SWITCHES)
    with ExitStack() as ending:
        # drops every callback while the nodes still exist
        ending.callback(executor.shutdown)
        ending.callback(gc.unfreeze)
        # also after an error: the last messages of a node stop the robot
        for node in reversed(nodes):
            ending.callback(node.close)
        # EventsExecutor.spin() never returns on a signal: spin in short turns and check the flag
        while not stop.requested and all(node.exit_code is None for node in nodes):
            executor.spin_once(timeout_sec=0.1)
            if stop.read_again:
                stop.read_again = False
                for node in nodes:
                    node.read_again()
    return max(node.exit_code or 0 for node in nodes)
