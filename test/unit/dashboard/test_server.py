"""What libraries log is printed in printable lines, and not one for each request."""

import logging

from mobile_robot_control.dashboard.server import LogLines


def test_a_record_is_one_printable_line_and_those_that_follow_are_counted(capsys):
    logger = logging.Logger('engineio.server')
    logger.addHandler(LogLines())
    logger.error('no page \x1b]0;X\x07\nTraceback')
    for _ in range(3):
        try:
            raise ValueError('\x1b[2J')
        except ValueError:
            logger.exception('a frame')
    line, = capsys.readouterr().err.splitlines()
    assert line == 'dashboard: engineio.server: no page \\x1b]0;X\\x07'


def test_the_line_after_a_quiet_time_has_the_error_and_the_number_left_out(capsys, monkeypatch):
    logger, now = logging.Logger('engineio.server'), [0.0]
    monkeypatch.setattr('time.monotonic', lambda: now[0])
    logger.addHandler(LogLines())
    for now[0] in (1.0, 2.0, 3.0, 20.0):
        try:
            raise ValueError('\x1b[2J')
        except ValueError:
            logger.exception('a frame')
    assert capsys.readouterr().err.splitlines()[1] == (
        'dashboard: engineio.server: a frame (ValueError: \\x1b[2J); 2 more before')
