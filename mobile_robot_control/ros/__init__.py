"""The four nodes and what they share."""
