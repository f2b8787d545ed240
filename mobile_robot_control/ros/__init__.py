"""The four nodes: the timing of their steps, their inputs, and their services."""
