"""The start of nodes: executables, ROS arguments, signals and the spin loop."""
