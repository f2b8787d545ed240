"""Figures as data, and their pictures by Matplotlib."""
