"""Drives judged by their path: no reference in time is needed."""
