"""The live page: watch and handle the robot in a browser."""
