"""The closed loop in one process, and its measurement."""
