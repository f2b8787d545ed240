"""
Stop the attached robot of an experiment when the standard input closes, by its end or because it was killed.

Arguments are the folder with `parameters.yaml` and the namespace. Before, nothing is published: a second publisher of
commands would be one too many.
"""

import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.experiment.stopping import is_at_rest, send_zeros
from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.quantities import BodyVelocity, WheelTorque
from mobile_robot_control.ros.shared import conversions
from mobile_robot_control.ros.shared.process import Stop
from mobile_robot_control.ros.shared.qos import SENSORS, flush, publish_on, subscribe_to
from mobile_robot_control.ros.start.spin import make_executor
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import PlantParameters, loop_of
from mobile_robot_control.system.supervisor import keep_node, leave_dds

_RATE = 50.0
"""[Hz]"""
_RECENT = 0.5
"""[s]: age of odometry that still shows whether the robot stands."""
_ZERO = {'cmd_vel': BodyVelocity(0.0, 0.0), 'wheel_torques': WheelTorque(0.0, 0.0)}


class Stopper(Node):
    """
    Hears a robot, and commands it to stand when asked to.

    Parameters
    ----------
    namespace : str
        Of the robot.
    plant : PlantParameters
        Of the run.

    """

    def __init__(self, namespace: str, plant: PlantParameters) -> None:
        super().__init__('stopper', namespace=namespace, enable_rosout=False)
        self._topic = loop_of(plant).command
        self._kind = loop_of(plant).topics[self._topic].kind
        self._write = conversions.writer(self._topic, plant.shared)
        self._read = conversions.reader('odom', plant.shared)
        self._heard, self._moves = -_RECENT, True
        self._publisher: Any = None
        subscribe_to(self, 'odom', self._take, SENSORS)

    def begin(self) -> None:
        """Begin to command the robot."""
        self._publisher = publish_on(self, self._topic, self._kind)

    def publish(self) -> None:
        """Publish a zero command."""
        self._publisher.publish(self._write(self.get_clock().now().nanoseconds, _ZERO[self._topic]))

    def stands(self) -> bool:
        """Return whether the robot stands, by recent odometry."""
        return not self._moves and time.monotonic() - self._heard < _RECENT

    def is_opposed(self) -> bool:
        """Return whether others command the robot, too."""
        return bool(self.count_publishers(self.resolve_topic_name(self._topic)) > 1)

    def end(self) -> None:
        """Wait until the robot has every command."""
        flush(self._publisher)

    def _take(self, message: bytes) -> None:
        try:
            _, velocity = self._read(message)
        except RefusedMessageError:
            return
        self._heard, self._moves = time.monotonic(), not is_at_rest(velocity)


def stop_at_the_end(folder: Path, namespace: str, stop: Stop) -> int:
    """Wait for the end of an experiment, and stop its robot; return 0 if it stands."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    stopper = Stopper(namespace, configure(load([folder / 'parameters.yaml'], namespace=namespace)).plant)
    keep_node(stopper)
    executor = make_executor()
    executor.add_node(stopper)
    turn = partial(executor.spin_once, timeout_sec=0.05)
    while not stop.requested:
        turn()
    stopper.begin()
    send_zeros(stopper, stopper.publish, stopper.stands, executor, _RATE, stopper.is_opposed)
    stopper.end()
    if not stopper.stands():
        print('zero commands were sent, and the robot is not seen to stand: stop it by its switch')
    return 0 if stopper.stands() else 1


if __name__ == '__main__':
    stopping = Stop()
    stopping.follow_parent()
    sys.exit(leave_dds(stop_at_the_end(Path(sys.argv[1]), sys.argv[2], stopping)))
