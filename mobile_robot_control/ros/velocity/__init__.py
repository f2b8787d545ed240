"""The node `velocity_controller`."""
