"""Of two controllers of one name, the younger one stands aside."""

import types
from collections import deque
from unittest.mock import MagicMock

import pytest

from mobile_robot_control.ros.position import namesakes
from mobile_robot_control.ros.position.namesakes import Namesakes

TICK = 0.02


class Controller:
    """Stands for the position controller, and for the node that listens for it: sends commands from a time on [s]."""

    def __init__(self, begins):
        self.begins, self.count, self.is_found, self.logged, self.context = begins, 0, False, [], self
        self.heard, self.commands = deque(), MagicMock()
        self.commands.handle.take_message = lambda *_: self.heard.popleft() if self.heard else None
        self.others = Namesakes(self, '', self.logged.append)

    def get_name(self):
        return 'position_controller'

    def get_namespace(self):
        return '/'

    def get_fully_qualified_name(self):
        return '/position_controller'

    def resolve_topic_name(self, topic):
        return topic

    def get_publishers_info_by_topic(self, _topic):
        return [types.SimpleNamespace(node_name=self.get_name(), node_namespace='/')] * (2 if self.is_found else 1)

    def create_subscription(self, *_):
        pass

    def get_logger(self):
        return types.SimpleNamespace(error=self.logged.append)

    def send(self, now, hearing):
        """Send a command, unless it stands aside."""
        if now < self.begins or self.others.reason:
            return
        self.count += 1
        message = f'{self.begins} {self.count}'.encode()
        self.others.note_sent(message)
        for one in hearing:
            if one.is_found:
                one.heard.append((message, {'publication_sequence_number': self.count}))


@pytest.mark.parametrize('found', [2.2, 9.0])
@pytest.mark.parametrize('begins', [0.3, 2.0])
def test_the_younger_controller_stands_aside_however_late_it_finds_the_other_one_and_both_do_if_they_begin_together(
    monkeypatch, begins, found
):
    now = [0.0]
    monkeypatch.setattr(namesakes, 'time', types.SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(namesakes, 'create_steady_timer', lambda _, look, node: setattr(node, 'look', look))
    monkeypatch.setattr(namesakes, 'Node', lambda *_, context, **__: context)
    monkeypatch.setattr(namesakes, 'subscribe_to', lambda node, *_: node.commands)
    both = [Controller(0.0), Controller(begins)]
    assert both[0].others.sending() == ''
    for n in range(round((found + 3.0) / TICK)):
        now[0] = n * TICK
        for one in both:
            one.is_found = now[0] >= found
            if n % 10 == 0:
                one.look()
            one.send(now[0], both)
    assert [one for one in both if one.others.reason] == (both if begins < 1.0 else both[1:])
    # it has not heard the other one for long, but found it a moment ago
    assert all(one.others.sending() for one in both)
    now[0] += 6.0
    assert not any(one.others.sending() for one in both)
    assert both[1].logged == [
        'the robot is not driven: 2 nodes named /position_controller send cmd_vel; end all but one, or give each robot '
        'a namespace, then call release']
