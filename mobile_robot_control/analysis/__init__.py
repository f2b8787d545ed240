"""What the numbers of a loop hold for: both loops linearised along the curve, their margins, and promises."""
