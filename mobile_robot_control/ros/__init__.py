"""The four nodes, what decides when they step, their inputs, and what serves them."""
