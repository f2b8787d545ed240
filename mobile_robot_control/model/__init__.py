"""The robot: wheel and body kinematics, dynamics."""
