"""A robot's numbers from recordings of its own: models, least squares, and the words for what is not known."""
