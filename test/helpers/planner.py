"""A planner on a grid of 5 cm: its route, the limits on it, and a plan from any place."""

import numpy as np

V, A, OMEGA, ALPHA = 0.4, 0.4, 1.2, 2.5
"""[m/s], [m/s²], [rad/s], [rad/s²]: limits of the cart, and of the pursuit."""
STARTS = [(0.0, 0.0, 0.72), (0.0, 0.0, 0.22), (0.0, 0.0, 1.22), (0.0, 0.0, 1.72), (0.0, 0.0, -0.28)]
"""Within 60° of the route's first direction."""


def route():
    """Return the points of a smooth route, a centimetre apart."""
    x = np.linspace(0.0, 5.15, 516)
    return np.stack([x, 0.8 * np.sin(1.1 * x)], axis=1)


ROUTE = route()


def plan_from(x, y):
    """Return a plan from a place to the end of the route, over the cells of a grid of 5 cm."""
    nearest = int(np.argmin(np.hypot(ROUTE[:, 0] - x, ROUTE[:, 1] - y)))
    return np.concatenate([[(x, y)], np.round(ROUTE[nearest + 5:-5:5] / 0.05) * 0.05, ROUTE[-1:]])


def across(points):
    """Return the distance of places from the route [m], which goes straight on beyond its end."""
    line = np.concatenate([ROUTE, ROUTE[-1:] + np.arange(1, 21)[:, None] * (ROUTE[-1:] - ROUTE[-2:-1])])
    return np.hypot(line[None, :, 0] - points[:, None, 0], line[None, :, 1] - points[:, None, 1]).min(axis=1)
