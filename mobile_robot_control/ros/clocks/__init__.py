"""When a node steps: lockstep or the wall clock, and what belongs to one of them alone."""
