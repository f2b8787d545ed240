"""Pages of runs, searches and studies."""
