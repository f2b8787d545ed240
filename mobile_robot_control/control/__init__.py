"""The control laws and what they share."""

import mobile_robot_control.control.laws  # noqa: F401 (so that they are registered)
