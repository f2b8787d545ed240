"""The parameters of the four nodes together: declared, checked, read from files, robots and tracks, and written."""
