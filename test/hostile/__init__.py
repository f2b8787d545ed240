"""Odd input: seeded cases of odd input, and the one rule that every command and node keeps; docs/robustness.md."""
