"""Nonlinear motion control of a differential-drive robot with a wheel-torque plant, on ROS 2."""

__version__ = '0.1.0'
