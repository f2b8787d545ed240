"""The parameters of a robot from its recordings: models, least squares, and texts on open questions."""
