"""The interface of what leads the cart, such as paths and corrections, and its view of the cart."""

from typing import Any, Protocol

from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.ros.cart.cart_course import CartCourse
from mobile_robot_control.ros.cart.cart_time import CartTime
from mobile_robot_control.ros.shared.inputs import InputMonitor, InputValidator
from mobile_robot_control.settings.nodes import ReferenceCartParameters
from mobile_robot_control.settings.shared import Shared


class Part(Protocol):
    """Leads the cart from a tick on."""

    def begin_run(self) -> None:
        """Begin a run on the course of the parameters."""

    def step(self, stamp: int) -> None:
        """Lead the cart at a tick [ns], before its reference."""

    def report(self, stamp: int) -> None:
        """Report what acts from a step [ns] on, after its outputs are published."""


class Cart(Protocol):
    """What its parts see of the node; `pose` is of the robot, `reference` of the last step."""

    parameters: ReferenceCartParameters
    shared: Shared
    validator: InputValidator
    monitor: InputMonitor
    course: CartCourse
    time: CartTime
    pose: Pose
    reference: Reference
    corrections: Any
    paths: Any
    goals: Any
    robot: Any

    @property
    def now(self) -> int:
        """The present time along the course [ns]."""

    def tell(self, values: dict[str, Any]) -> None:
        """Show values in the diagnostics."""

    def publish_path(self) -> None:
        """Publish the present course."""

    def publish_event(self, stamp: int, event: dict[str, Any]) -> None:
        """Publish an event of a step [ns]."""

    def get_logger(self) -> Any:
        """Return the log."""
