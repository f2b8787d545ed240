"""The curves that the reference cart drives."""
