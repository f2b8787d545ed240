"""The closed loop in one process, and what is measured on it."""
