"""The spin loop: the last messages of nodes, which stop a robot, are published however it ends."""

import types

import pytest

from mobile_robot_control.ros.start import spin


@pytest.mark.parametrize('error', [ValueError('of a callback'), SystemExit(3), KeyboardInterrupt()], ids=repr)
def test_nodes_are_closed_after_any_error_also_where_closing_one_fails(monkeypatch, error):
    done = []

    def fail(_node=None, **_):
        raise error

    executor = types.SimpleNamespace(add_node=done.append, spin_once=fail, shutdown=lambda: done.append('shut down'))
    monkeypatch.setattr(spin, 'make_executor', lambda: executor)
    first, second = (types.SimpleNamespace(exit_code=None, close=lambda name=name: done.append(name) or fail())
                     for name in ('first', 'second'))
    with pytest.raises(type(error)):
        spin._spin([first, second], types.SimpleNamespace(requested=False, read_again=False))
    assert done == [first, second, 'first', 'second', 'shut down']
