"""The search for gains, and Monte Carlo studies of their robustness."""
