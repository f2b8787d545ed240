"""Position controller and waiting cart of the wall clock, without ROS."""

import math
import types

from helpers.harness import CONFIG
from mobile_robot_control.control.compensation import carried_forward
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.reference.waiting import begin_waiting, move_cart, slowed
from mobile_robot_control.ros.position.law_runner import LawRunner
from mobile_robot_control.ros.position.robot_guard import RobotGuard
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

PARAMETERS = configure(load([CONFIG / 'wall_clock.yaml']))
NODE = types.SimpleNamespace(
    get_logger=lambda: types.SimpleNamespace(error=print, info=print), create_service=lambda *_: None,
    create_publisher=lambda *_: types.SimpleNamespace(publish=lambda _: None),
    context=types.SimpleNamespace(get_domain_id=lambda: -1), get_fully_qualified_name=lambda: '/without_ros',
    create_timer=lambda *_, **__: None)


class Following:
    """Position controller and cart without ROS; notes each step's command, distance and time, and how many waited."""

    def __init__(self, law, approach_speed, limit=0.0):
        self.curve = PARAMETERS.reference_cart.curve
        ours = PARAMETERS.position_controller
        # the steps of a law may take long on a busy machine
        self._values = ours._replace(input_timeout=60.0, control=ours.control._replace(controller_type=law),
                                     limits=ours.limits._replace(tracking_error=limit),
                                     approach=ours.approach._replace(speed=approach_speed))
        self._law = LawRunner(NODE, self._values.control, 1.0 / ours.shared.position_rate, lambda: None)
        self.drive = RobotGuard(NODE, self._law, lambda: None, str, lambda _: None, '')
        self._cart, self._distance = None, PARAMETERS.reference_cart.waiting.wait_distance
        self._at = self.reference(0.0).pose
        self.commands, self.apart, self.times, self.waited = [], [], [], 0

    def reference(self, time):
        return reference_at(CURVES[self.curve.curve], time, self.curve.placement)

    def __call__(self, time, stamp, pose, velocity):
        pose, velocity = Pose(*pose), BodyVelocity(*velocity)
        before = self._cart or begin_waiting(time, pose)
        self._cart = move_cart(before, time, time - stamp, pose, self._at, self._distance)
        self.waited += bool(self._cart.why)
        self.times.append(self._cart.time)
        reference = slowed(self.reference(self._cart.time), self._cart.rate)
        self._at = reference.pose
        pose = carried_forward(pose, velocity, time - stamp)
        error = tracking_error(reference.pose, pose)
        command = self.drive.command(Observation(error, reference, velocity), 0, self._values)
        assert not self._law.failure
        self.commands.append(command)
        self.apart.append(math.hypot(error.longitudinal, error.lateral))
        return command
