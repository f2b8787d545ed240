"""The control laws and what they share."""
