"""The closed loop in one process: ticks, trials, batches and scenarios."""
