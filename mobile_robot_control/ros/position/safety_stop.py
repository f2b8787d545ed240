"""The stop of a robot on the wall clock: by a service or a limit, until its release, also across a restart."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import errno
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from mobile_robot_control.control.limits import allowed_distance
from mobile_robot_control.ros.position.namesakes import Namesakes
from mobile_robot_control.ros.shared.process import ros_home
from mobile_robot_control.ros.shared.qos import LATCHED
from mobile_robot_control.system.files import FileKind, explain, read_bounded, write_atomically
from mobile_robot_control.topics import STOPPED

_STOP = FileKind('reason of a stop', 1 << 16)


class StopMemory:
    """
    Keeps the reason of a stop in a file below ROS_HOME, for a node that is started again.

    Parameters
    ----------
    domain : int
        ROS domain of the node.
    name : str
        Its full name, with its namespace.

    Attributes
    ----------
    file : Path
        Exists while the robot is stopped.

    """

    def __init__(self, domain: int, name: str) -> None:
        self.file = Path(ros_home(), 'mobile_robot_control', 'stops', str(domain), f'{name.lstrip("/")}.txt')

    def recall(self) -> str:
        """Return the reason of a stop that holds; '' without one."""
        try:
            reason = read_bounded(self.file, _STOP).decode(errors='backslashreplace')
        except (FileNotFoundError, NotADirectoryError):
            return ''
        except OSError as error:
            # a stop whose reason cannot be read is a stop
            return f'{self.file} cannot be read ({error.strerror}); make it readable or remove it, then call release'
        return reason or f'{self.file} has no reason; call release to drive on'

    def keep(self, reason: str) -> str:
        """Write the reason of a stop, or remove the file for ''; return why that failed, '' if it did not."""
        try:
            if not self.file.is_absolute():
                raise OSError(errno.ENOENT, 'there is no folder for it; set ROS_HOME or HOME', str(self.file))
            if not reason:
                self.file.unlink(missing_ok=True)
                return ''
            self.file.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(self.file, reason)
            folder = os.open(self.file.parent, os.O_RDONLY)
            try:
                os.fsync(folder)  # a robot that is switched off after its stop keeps the file
            finally:
                os.close(folder)
        except OSError as error:
            return explain(error)
        return ''


_JOIN, _MOST = '; and ', 3
"""Between the reasons of a stop, and most of them: a base that dies again and again writes no book."""
STOP, RELEASE = '~/stop', '~/release'
_BY_REQUEST = 'by a call of stop; call release to drive on'
_IN_LOCKSTEP = ('in lockstep there is no robot to stop: simulated time stands still while the parameter paused of the '
                'plant is true')


def refuse_to_stop(node: Node) -> None:
    """Serve `stop` and `release` in lockstep, where both are refused."""

    def answer(_request: Any, response: Any) -> Any:
        response.success, response.message = False, _IN_LOCKSTEP
        return response

    node.create_service(Trigger, STOP, answer)
    node.create_service(Trigger, RELEASE, answer)


class SafetyStop:
    """
    Serves `stop` and `release`, and stops a robot that is too far from the reference; a stop outlives the node.

    Parameters
    ----------
    node : Node
        The position controller.
    act : callable
        Called after each request: applies it at once and returns the condition of the node in words.
    note : callable
        Called with the reason of each stop, and with '' at each release.
    others : Namesakes
        Other nodes of this name, while which send no release acts.

    Attributes
    ----------
    reason : str
        Reason of the stop; '' without one.

    """

    def __init__(
        self, node: Node, act: Callable[[], str], note: Callable[[str], None], others: Namesakes
    ) -> None:
        self._node, self._act, self._note, self._others = node, act, note, others
        self.reason = ''
        self._closest = math.inf
        self._publisher = node.create_publisher(String, STOPPED, LATCHED)
        self._memory = StopMemory(node.context.get_domain_id(), node.get_fully_qualified_name())
        self._kept = self._memory.recall()
        if self._kept:
            self.stop(self._kept)
        node.create_service(Trigger, STOP, self._on_stop)
        node.create_service(Trigger, RELEASE, self._on_release)

    def allows(self, apart: float, limit: float, approaching: bool) -> bool:
        """
        Return whether a robot may drive at this distance from the reference; if not, stop it.

        Parameters
        ----------
        apart : float
            Distance from the reference [m].
        limit : float
            `limits.tracking_error` [m], 0 for none.
        approaching : bool
            Whether it approaches a waiting cart: the limit then applies to the increase over its smallest distance.

        """
        self._closest = min(self._closest, apart) if approaching else math.inf
        if apart <= allowed_distance(self._closest if approaching else 0.0, limit):
            return True
        self.stop(f'{apart:.2f} m from the reference, and limits.tracking_error is {limit:g} m; bring the robot '
                  'back or raise the limit, then call release')
        return False

    def stop(self, reason: str) -> None:
        """Stop the robot until its release; up to three reasons join, so that one release suffices."""
        told = self.reason.split(_JOIN) if self.reason else []
        if len(told) < _MOST and reason not in told:
            told.append(reason)
        self._change(_JOIN.join(told))

    def remember(self) -> str:
        """Bring the memory up to date, after the zero command; return why that failed, '' if it did not."""
        if self._kept == self.reason:
            return ''
        self._kept = self.reason
        fault = self._memory.keep(self.reason)
        if not fault:
            return ''
        fault = (f'the stop does not outlive this node: {fault}' if self.reason else
                 f'once this node is started again the robot is stopped again: {fault}')
        self._node.get_logger().error(fault)
        return fault

    def _on_stop(self, _request: object, response: object) -> Any:
        return self._answer(response, self.reason or _BY_REQUEST)

    def _on_release(self, _request: Any, response: Any) -> Any:
        several = self._others.sending()
        if several:
            response.success, response.message = False, several
            return response
        self._others.reason = ''
        return self._answer(response, '')

    def _answer(self, response: Any, reason: str) -> Any:
        """Stop the robot, or release it without a reason; answer with the resulting state."""
        self._change(reason)
        now = self._act()
        fault = self.remember()
        response.message = (now if self.reason else f'released: {now}') + (fault and f'; {fault}')
        # a robot released too far from the reference stops again
        response.success = bool(self.reason) == bool(reason)
        return response

    def _change(self, reason: str) -> None:
        """Log a change, once."""
        if reason and not self.reason:
            self._node.get_logger().error(f'the robot is stopped: {reason}')
        elif self.reason and not reason:
            self._node.get_logger().info('the robot is released')
        if bool(reason) != bool(self.reason):
            self._note(reason)
        self.reason, self._closest = reason, math.inf
        self._publisher.publish(String(data=reason))
