"""The report of runs: its page, its command, and its place in a notebook."""
