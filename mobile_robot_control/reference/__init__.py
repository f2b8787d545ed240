"""The reference cart's curves and paths."""

import mobile_robot_control.reference.curves  # noqa: F401 (so that they are registered)
