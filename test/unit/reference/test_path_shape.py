"""The shape of a path: near its corners, straight between them, of continuous curvature."""

import numpy as np
import pytest
from helpers.timed_paths import RECTANGLE, shape_of

from mobile_robot_control.reference.path_shape import lay_grid


@pytest.mark.parametrize('closed', [False, True])
def test_a_path_is_within_its_tolerance_of_the_corners_and_straight_between_them(closed):
    spans = shape_of(RECTANGLE, closed, 0.05)
    points = np.array([spans[n].at(u)[:2] for n in range(len(spans)) for u in np.linspace(0.0, 1.0, 50)])
    for corner in RECTANGLE:
        assert np.hypot(*(points - corner).T).min() <= 0.05 + 1e-12
    middle = points[np.abs(points[:, 0] - 1.0) < 0.5]
    assert np.minimum(abs(middle[:, 1]), abs(middle[:, 1] - 1.0)).max() < 1e-12
    if not closed:
        assert tuple(points[0]) == pytest.approx(RECTANGLE[0])
        assert tuple(points[-1]) == pytest.approx(RECTANGLE[-1])


def test_curvature_is_continuous_and_the_sharpness_its_slope():
    grid = lay_grid(shape_of(RECTANGLE, True))
    assert np.abs(grid.curvature[:-1, 1] - grid.curvature[1:, 0]).max() < 1e-9
    # trapezoidal rule, within each interval
    risen = np.diff(grid.curvature, axis=1)[:, 0]
    assert np.abs(risen - grid.sharpness.mean(axis=1) * grid.length).max() < 0.01
    assert (np.abs(grid.curvature).max(axis=1) * grid.length).max() <= 0.3
