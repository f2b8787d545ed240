"""Files, texts, signals and the standard streams, for every part of the package."""
