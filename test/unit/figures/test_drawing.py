"""The pictures of `tune` and `study`: a PNG, and beside it an SVG in which every colour turns dark."""

import math
import re
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest
from helpers.measuring import configuration
from PIL import Image

from mobile_robot_control.figures.drawing import draw, draw_and_save
from mobile_robot_control.loop.monte_carlo import Judged
from mobile_robot_control.loop.scenarios import Scenario
from mobile_robot_control.quantities import Pose, WheelTorque
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.search.page import search_figure
from mobile_robot_control.search.search import Generation
from mobile_robot_control.studying import page
from mobile_robot_control.studying.failures import Split
from mobile_robot_control.studying.page import StudiedRuns, starts_figure

HISTORY = [Generation(1, 8.0, 20.0, 3), Generation(2, 6.5, math.nan, 41), Generation(3, 4.2, 9.0, 0)]
UNKNOWN = WheelTorque(math.nan, math.nan)


class Start(NamedTuple):
    """Where a run started, and how it ended."""

    offset: Pose
    success: bool
    outcome: str = 'completed'


STARTS = [Start(Pose(1.0, -1.0, 1.0), True), Start(Pose(-1.0, 1.0, -2.0), False)]


@pytest.fixture(scope='module')
def loops():
    laws = {'before': 'backstepping', 'after': 'fuzzy'}
    return {name: list(rollout(configuration(position_controller={'controller_type': law}), 0.5))
            for name, law in laws.items()}


def assert_turns_dark(file):
    """The SVG has a rule for dark ground for each colour that it is drawn with."""
    rules, drawing = re.fullmatch(r'.*?<style>(.*?)</style>(.*)', file.read_text(encoding='utf-8'), re.DOTALL).groups()
    assert 'prefers-color-scheme: dark' in rules
    colors = set(re.findall(r'(?:fill|stroke): #\w{6}', drawing))
    assert len(colors) > 4
    for color in colors:
        assert f'[style*="{color}"]' in rules


def assert_wide(file, width):
    with Image.open(file) as picture:
        assert picture.format == 'PNG'
        assert picture.width > width
        pixels = np.asarray(picture.convert('L'))
    assert pixels.std() > 5.0
    for border in (pixels[:2], pixels[-2:], pixels[:, :2], pixels[:, -2:]):
        assert border.min() == border.max(), 'something is cut off'


def runs_of(loops):
    return [Run(name, collect(samples), (), {}, None) for name, samples in loops.items()]


def studied(starts, split=None):
    """Return runs of a controller that started and ended so; they fail where a split says."""
    scenarios = [Scenario('trifolium', 1.0, start=start.offset) for start in starts]
    return StudiedRuns(scenarios, [Judged(start.success, {}, start.outcome) for start in starts], split, {})


def test_searches_are_drawn_as_png_and_as_svg_that_turns_dark(loops, tmp_path):
    # of one generation, after a loop that diverged at once
    for name, history, before in (('gains', HISTORY, loops['before']), ('of.friday', HISTORY[:1], loops['before'][:1])):
        figure = search_figure('fuzzy: objective 4.2', history, runs_of(loops | {'before': before}))
        draw_and_save(figure, tmp_path / f'{name}.png')
        assert_wide(tmp_path / f'{name}.png', 1000)
        assert_turns_dark(tmp_path / f'{name}.svg')
    assert len(list(tmp_path.iterdir())) == 4


def test_starts_are_drawn_as_png_and_as_svg_that_turns_dark(tmp_path, monkeypatch):
    # with any name, without a failure, and whatever the date of a reproducible build is
    monkeypatch.setenv('SOURCE_DATE_EPOCH', 'today')
    figure = starts_figure({'law': studied(STARTS), '$\\frac$: 50 %_': studied(STARTS), 'good': studied(STARTS[:1])})
    draw_and_save(figure, tmp_path / 'starts.png')
    assert_wide(tmp_path / 'starts.png', 1800)
    assert_turns_dark(tmp_path / 'starts.svg')
    ElementTree.parse(tmp_path / 'starts.svg')  # noqa: S314 (our own file)
    assert len(list(tmp_path.iterdir())) == 2


def test_the_map_shows_how_runs_ended_and_where_most_fail(monkeypatch):
    starts = [*STARTS, Start(Pose(-0.5, 0.5, 0.0), False, 'diverged'), Start(Pose(0.5, 0.5, 0.0), False, 'law_failed')]
    near = Split('start_distance', 'above', 0.83, (10, 57), (2, 243), 0.001)
    heavy = Split('mass_factor', 'above', 1.1, (10, 57), (2, 243), 0.001)
    splits = iter((heavy, near))
    monkeypatch.setattr(page, 'best_split', lambda scenarios, judged: next(splits))
    figure = draw(starts_figure({'a': studied(STARTS), 'b': studied(starts)}))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        'success', 'failure: too far away', 'failure: diverged', 'failure of the law']
    left, right = figure.axes
    assert left.get_title() == 'a: 50.00 %\nmass factor above 1.1: 10 of 57 fail,\nelsewhere 2 of 243'
    assert right.get_title() == 'b: 25.00 %\nstart distance above 0.83 m: 10 of 57 fail,\nelsewhere 2 of 243'
    assert not left.patches
    circle, = right.patches
    assert circle.get_radius() == 0.83
    shown = [tuple(points) for part in right.collections for points in part.get_offsets()]
    assert sorted(shown) == sorted((start.offset.x, start.offset.y) for start in starts)


def test_a_search_of_a_base_that_takes_no_torque_has_no_frame_for_it(loops):
    driven = {name: [sample._replace(applied=UNKNOWN, torque=UNKNOWN) for sample in samples]
              for name, samples in loops.items()}
    drawn = [draw(search_figure('a search', HISTORY, runs_of(samples))) for samples in (loops, driven)]
    labels = [[axes.get_ylabel() for axes in figure.axes] for figure in drawn]
    assert [any('torque' in label for label in found) for found in labels] == [True, False]
    assert all(axes.lines for figure in drawn for axes in figure.axes)
