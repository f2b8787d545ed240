"""The node `reference_cart`, its course and time, paths, goals and the corrections of a localisation."""
