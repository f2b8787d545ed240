"""The ROS parts of every node: parameters, quality of service, diagnostics, timers, its start and its end."""
