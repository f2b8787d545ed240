"""A position law of one's own for mobile_robot_control."""
