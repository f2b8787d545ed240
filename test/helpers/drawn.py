"""A drawn sample of a matrix of cases, always the same one; the rest are run by `make soak`."""

import itertools
import random

import pytest


def drawn(*columns, seed=1):
    """
    Return the product of columns as parameters of a test; cases that are not drawn are marked as soak.

    Those drawn show each value once. Take another seed where a change of the code shows in a case that was not drawn.
    """
    columns = [list(column) for column in columns]
    draw, count = random.Random(seed), max(map(len, columns))  # noqa: S311 (cases, no secrets)
    orders = [draw.sample(range(len(column)), len(column)) for column in columns]
    kept = {tuple(order[number % len(order)] for order in orders) for number in range(count)}
    return [pytest.param(*(column[place] for column, place in zip(columns, places, strict=True)),
                         marks=() if places in kept else pytest.mark.soak)
            for places in itertools.product(*map(range, map(len, columns)))]
