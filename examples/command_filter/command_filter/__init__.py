"""A node of one's own for mobile_robot_control."""
