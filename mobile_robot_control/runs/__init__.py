"""Runs as columns: read from bags, tables and rollouts, joined on one time base, and measured."""
