"""The animation of a run."""

import pytest
from helpers.measuring import configuration
from PIL import Image

from mobile_robot_control.report import animation
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.runs.series import Series


@pytest.fixture(scope='module')
def fuzzy():
    return configuration(position_controller={'controller_type': 'fuzzy'})


@pytest.fixture(scope='module')
def series(fuzzy):
    return collect(rollout(fuzzy, 1.0))


def test_an_animation_has_its_frames_stays_small_and_has_bars_of_torques_only_where_they_are_known(
        series, tmp_path, monkeypatch):
    figures, made = [], animation.Figure
    monkeypatch.setattr(animation, 'Figure', lambda **options: figures.append(made(**options)) or figures[-1])
    alone = Series({topic: series.signals[topic] for topic in ('odom', 'reference')})
    for run, name in ((series, 'run.webp'), (alone, 'alone.gif')):
        animation.animate(run, tmp_path / name, frames=4)
        with Image.open(tmp_path / name) as picture:
            assert picture.n_frames == 4
            assert picture.width > 400
        assert (tmp_path / name).stat().st_size < 200_000
    assert [len(figure.axes) for figure in figures] == [2, 1]
    with pytest.raises(ValueError, match='without odometry'):
        animation.animate(Series({}), tmp_path / 'none.gif')
