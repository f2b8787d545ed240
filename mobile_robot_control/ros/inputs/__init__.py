"""The inputs of a node: their table, checked messages, their ages and their faults."""
