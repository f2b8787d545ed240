"""The nodes: what each does in a step, and what it publishes."""
