"""Monte Carlo studies, from their request to their page."""
