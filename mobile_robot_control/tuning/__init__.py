"""The search for gains, and Monte Carlo studies of how robust they are."""
