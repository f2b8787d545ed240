"""Runs: simulated, read from bags and tables, joined on one time base, measured, and written."""
