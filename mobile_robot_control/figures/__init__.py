"""Figures as data, and the pictures that Matplotlib draws of them."""
