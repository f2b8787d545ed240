"""The commands as functions that return arrays, for notebooks and scripts."""
