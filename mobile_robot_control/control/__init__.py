"""The control laws and their shared parts."""

import mobile_robot_control.control.laws  # noqa: F401 (so that they are registered)
