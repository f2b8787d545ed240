"""The benchmark of laws, from its request to its page."""
