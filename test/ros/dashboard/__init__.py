"""A package, so that its dashboard ends with its last test."""
