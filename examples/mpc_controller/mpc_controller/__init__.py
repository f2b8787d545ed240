"""A model predictive position law for mobile_robot_control."""
