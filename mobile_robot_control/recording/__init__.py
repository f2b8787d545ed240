"""Runs as bags and as time series."""
