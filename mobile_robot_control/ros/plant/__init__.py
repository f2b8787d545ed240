"""The node `plant`: the simulated robot, its questions and disturbances."""
