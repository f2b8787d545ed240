"""The grade of a model."""

import numpy as np
import pytest

from mobile_robot_control.identification import judgement
from mobile_robot_control.identification.result import Prediction


@pytest.mark.parametrize(('missed', 'grade'), [(0.02, 'good'), (0.2, 'usable'), (0.7, 'unusable')])
def test_a_model_is_graded_by_the_share_of_the_motion_that_it_misses_and_by_regime(missed, grade):
    times = 0.05 * np.arange(1200)
    # by turns on the spot and straight on, 6 s each: the turns on the spot are missed
    on_the_spot = (times % 12.0 < 6.0)
    modelled = np.column_stack([np.where(on_the_spot, 0.0, 0.5), np.where(on_the_spot, 1.0, 0.0)])
    noise = np.random.default_rng(0).normal(0.0, 0.01, modelled.shape)
    measured = modelled * [1.0, 1.0 / (1.0 - missed)] + noise
    one = Prediction('bag', times, measured, modelled, 48.0, *[np.zeros((2, 3))] * 2)
    judged = judgement.judge([one])
    assert judged.grade == grade
    assert judged.shares == pytest.approx((0.0, missed), abs=0.02)
    assert max(judged.regimes, key=lambda name: judged.regimes[name][1]) == 'turning on the spot'
    assert judged.regimes['driving'][1] < 0.02
    assert len(list(judgement.slip_with_curvature([one]))) == 0
