"""The excitation of a robot, for a recording that identifies it."""
