"""The plan of a path, from its request to its page."""
