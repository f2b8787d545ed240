"""Shared by unit tests: searches, studies and reports without what takes time and is tested elsewhere."""

import signal

import pytest


@pytest.fixture(autouse=True)
def signal_handlers():
    """Restore the handlers of signals that the parser of `experiment` installs for the rest of a process."""
    before = {number: signal.getsignal(number) for number in (
        signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def quick(monkeypatch):
    """A report draws one figure of each kind."""
    from mobile_robot_control.report import report_writing

    for figures in ('RUN_FIGURES', 'TIMING_FIGURES'):
        monkeypatch.setattr(report_writing, figures, getattr(report_writing, figures)[:1])


@pytest.fixture
def plain(monkeypatch, quick):
    """A search or a study compiles and draws nothing."""
    from mobile_robot_control.figures import drawing
    from mobile_robot_control.loop import batch

    monkeypatch.setattr(batch, 'COMPILES', False)
    monkeypatch.setattr(drawing, 'draw_and_save', lambda *_: '')
