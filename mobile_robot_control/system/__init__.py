"""Files, texts, signals and the standard streams, as every part of the package uses them."""
