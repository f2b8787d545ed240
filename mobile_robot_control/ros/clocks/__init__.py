"""The timing of a node's steps, in lockstep or on the wall clock, and everything specific to one of them."""
