"""The search for gains, from its request to its page."""
