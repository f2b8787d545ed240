"""The command `excite` before anything moves."""

import sys

import pytest

from mobile_robot_control.cli import excite


def test_without_yes_it_says_what_it_would_do_and_does_not_join_ros(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, 'rclpy', None)
    monkeypatch.delitem(sys.modules, 'mobile_robot_control.experiment.excitation_run', raising=False)
    assert excite.main(['--box', '2', '3', '--max-velocity', '0.5']) == 0
    assert 'within 1 m ahead and behind, and 1.5 m to both sides' in capsys.readouterr().out


@pytest.mark.parametrize(('arguments', 'told'), [
    (['--box', '1', '3', '--max-velocity', '0.4', '--yes'], 'take sides of 1.6 m, or a max_velocity of 0.25 m/s'),
    (['--box', '2', '2', '--yes', '--bag', '.'], '--bag .: it is there already'),
])
def test_what_cannot_be_done_is_refused_before_anything_moves(arguments, told, capsys):
    assert excite.main(arguments) == 2
    assert told in capsys.readouterr().err
