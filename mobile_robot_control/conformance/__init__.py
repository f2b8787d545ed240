"""The checks of laws and curves that `testing` runs."""
