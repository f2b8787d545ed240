"""What tests share: stand-ins for robots and planners, processes, drawn inputs, ways to look at pages and runs."""
