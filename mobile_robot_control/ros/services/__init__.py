"""What every node needs of ROS: parameters, quality of service, diagnostics, timers, its start and its end."""
