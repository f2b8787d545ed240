"""What a node is given: its table of inputs, checked messages, their ages and what is odd about them."""
