"""Each law on each curve, with the whole plant at 500 and 100 Hz, within a named bound."""

import math

import pytest
from drawn import drawn
from measuring import configuration, measured

VELOCITY = {'gains.k1': 1.0, 'gains.ti1': 10.0, 'gains.k2': 0.3, 'gains.ti2': 10.0}
BACKSTEPPING = {f'backstepping.{name}': value for name, value in
                {'p': 2.0, 'q': 0.5, 'alpha': 1.0, 'f': 1.0, 'g': 4.0}.items()}
FUZZY = {'fuzzy.a': 0.5, 'fuzzy.b': [0.6, 0.1, 0.7, 1.6, 0.8, 2.2], 'fuzzy.c': [-0.4, -0.1, 0.0, 0.3, 0.8],
         'fuzzy.d': [-3.0, 0.0, 3.0]}
# [m]: RMS over the lap when started on the curve, largest distance at its end wherever started. The fuzzy law has no
# feed-forward, so it follows at a distance.
BOUNDS = {'backstepping': (0.012, 0.015), 'hybrid_backstepping': (0.08, 0.015), 'fuzzy': (0.30, 0.30)}
CURVES = ['trifolium', 'lemniscate', 'circle']


def lap(law, curve, start, **plant):
    return measured(configuration(
        plant={'initial_pose': start, **plant}, velocity_controller=VELOCITY,
        position_controller={'controller_type': law, **BACKSTEPPING, **FUZZY}, reference_cart={'curve': curve},
    ), 16.0)


@pytest.mark.parametrize(('law', 'curve'), drawn(BOUNDS, CURVES))
def test_each_law_started_on_the_curve_stays_within_its_bound(law, curve):
    found, last = lap(law, curve, [1.0, 0.0, 0.5 * math.pi])
    rms, end = BOUNDS[law]
    assert found['rms_position_error'] < rms
    assert math.hypot(*last.tick.error[:2]) < end


@pytest.mark.parametrize(('law', 'curve', 'start'), drawn(BOUNDS, CURVES, [[0.8, 0.1, 2.2], [1.3, -0.4, -1.0]]))
def test_each_law_reaches_the_curve_from_beside_it(law, curve, start):
    _, last = lap(law, curve, start)
    assert math.hypot(*last.tick.error[:2]) < BOUNDS[law][1]


@pytest.mark.parametrize('law', BOUNDS)
def test_each_law_follows_the_line(law):
    found, last = lap(law, 'line', [0.0, 0.0, 0.0])
    assert found['rms_position_error'] < 0.05
    assert math.hypot(*last.tick.error[:2]) < 0.05


def test_backstepping_reaches_the_curve_with_centripetal_coupling():
    _, last = lap('backstepping', 'trifolium', [0.8, 0.1, 2.2], centripetal_coupling=True)
    assert math.hypot(*last.tick.error[:2]) < BOUNDS['backstepping'][1]
