"""Position controller and reference cart of the wall clock without ROS: a control for `stand_in_model.drive`."""

import math
import types

from mobile_robot_control.control.latency import carried_forward
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.reference.waiting import begin_waiting, move_cart, slowed
from mobile_robot_control.ros.clocks.robot_guard import RobotGuard
from mobile_robot_control.ros.nodes.law_runner import LawRunner

NODE = types.SimpleNamespace(
    get_logger=lambda: types.SimpleNamespace(error=print), create_service=lambda *_: None,
    create_publisher=lambda *_: types.SimpleNamespace(publish=lambda _: None),
    create_subscription=lambda *_, **__: None)
"""Stands for the position controller."""


class Following:
    """
    Both nodes by turns, with what they note.

    `commands` and `apart` [m] are lists of each step, `waited` how many of them the cart waited.
    """

    def __init__(self, parameters, law, approach_speed, waits=True, limit=0.0):
        self.curve = parameters.reference_cart.curve
        self._waits = waits
        ours = parameters.position_controller
        self._values = ours._replace(control=ours.control._replace(controller_type=law),
                                     limits=ours.limits._replace(tracking_error=limit),
                                     approach=ours.approach._replace(speed=approach_speed))
        self._law = LawRunner(NODE, self._values.control, 1.0 / ours.shared.position_rate, lambda: None)
        self.drive = RobotGuard(NODE, self._law, None, lambda: None, str, lambda _: None)
        self._cart = None
        self._distance = parameters.reference_cart.waiting.wait_distance
        self._at = self.reference(0.0).pose
        self.commands, self.apart, self.times, self.waited = [], [], [], 0

    def reference(self, time):
        return reference_at(CURVES[self.curve.curve], time, self.curve.placement)

    def __call__(self, time, stamp, pose, velocity):
        pose, velocity = Pose(*pose), BodyVelocity(*velocity)
        reference = self._advanced(time, stamp, pose) if self._waits else self.reference(time)
        self._at = reference.pose
        pose = carried_forward(pose, velocity, time - stamp)
        error = tracking_error(reference.pose, pose)
        command = self.drive.command(Observation(error, reference, velocity), 0, self._values)
        assert not self._law.failure
        self.commands.append(command)
        self.apart.append(math.hypot(error.longitudinal, error.lateral))
        return command

    def _advanced(self, time, stamp, pose):
        before = self._cart or begin_waiting(time, pose)
        self._cart = move_cart(before, time, time - stamp, pose, self._at, self._distance)
        self.waited += bool(self._cart.why)
        self.times.append(self._cart.time)
        return slowed(self.reference(self._cart.time), self._cart.rate)
