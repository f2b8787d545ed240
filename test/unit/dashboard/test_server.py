"""What libraries log is printed in printable lines, and not one for each request."""

import logging

from mobile_robot_control.dashboard.server import LogLines


def test_records_are_printable_lines_and_those_that_follow_soon_are_counted(capsys, monkeypatch):
    logger, now = logging.Logger('engineio.server'), [0.0]
    monkeypatch.setattr('time.monotonic', lambda: now[0])
    logger.addHandler(LogLines())
    logger.error('no page \x1b]0;X\x07\nTraceback')
    for now[0] in (1.0, 2.0, 3.0, 20.0):
        try:
            raise ValueError('\x1b[2J')
        except ValueError:
            logger.exception('a frame')
    assert capsys.readouterr().err.splitlines() == [
        'dashboard: engineio.server: no page \\x1b]0;X\\x07',
        'dashboard: engineio.server: a frame (ValueError: \\x1b[2J); 3 more before']
