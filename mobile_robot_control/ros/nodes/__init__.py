"""The nodes: the steps of each, and its outputs."""
