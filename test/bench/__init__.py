"""Benchmarks: what this package costs beyond what ROS 2 itself costs, as ratios measured in one run."""
