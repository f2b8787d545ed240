"""Search for gains, and the study of what they stand."""
