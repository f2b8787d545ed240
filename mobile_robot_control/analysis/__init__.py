"""The validity of numbers: both loops linearised along the curve, their margins, and promises."""
