"""The curves that the reference cart drives."""

import mobile_robot_control.reference.curves  # noqa: F401 (so that they are registered)
