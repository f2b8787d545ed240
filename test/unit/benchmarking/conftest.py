"""Benchmarks without compilation, and their small track."""

import pytest
from helpers.small_benchmark import TRACK

from mobile_robot_control.loop import batch


@pytest.fixture(autouse=True)
def uncompiled(monkeypatch, registered):
    monkeypatch.setattr(batch, 'COMPILES', False)


@pytest.fixture
def track(tmp_path):
    file = tmp_path / 'small.yaml'
    file.write_text(TRACK)
    return file
