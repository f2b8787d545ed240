"""What a page asks for is checked, whatever it sends, and answered in words."""

import asyncio
from concurrent.futures import Future

import pytest

from mobile_robot_control.configuration.files import load
from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.dashboard.actions import Actions
from mobile_robot_control.dashboard.recordings import save_parameters
from mobile_robot_control.parameters.declaration import flatten


class Book:
    """Stands for the parameters of a graph on which no node has told any."""

    def __init__(self):
        self.nodes = {}

    @staticmethod
    def set(node, values):
        done = Future()
        done.set_result(f'{node} refuses {", ".join(map(str, values))}')
        return done


class Link:
    """Stands for a link to that graph."""

    def __init__(self):
        self.book = Book()

    @staticmethod
    def submit(job):
        done = Future()
        try:
            result = job()
            done.set_result(result.result() if isinstance(result, Future) else result)
        except Exception as error:
            done.set_exception(error)
        return done


@pytest.mark.parametrize('asked', [
    None, 3, [], {}, {'do': 'format'}, {'do': ['set']}, {'do': []}, {'do': {}},
    {'do': 'set'}, {'do': 'set', 'node': 1, 'values': {'a': 1}},
    {'do': 'set', 'node': 'plant', 'values': {}}, {'do': 'set', 'node': 'plant', 'values': dict.fromkeys(range(51))},
    {'do': 'disturb'}, {'do': 'disturb', 'key': 'Enter'}, {'do': 'disturb', 'key': {}}, {'do': 'curve'},
    {'do': 'reset', 'pose': 'here'}, {'do': 'save'}, {'do': 'record', 'name': '../..'}, {'do': 'set', 'values': 'x'},
])
def test_a_request_without_sense_is_refused_in_words(asked, tmp_path):
    class NothingToRecord:
        @staticmethod
        def start(present):
            raise OSError('no room')

    answer = asyncio.run(Actions(Link(), NothingToRecord, tmp_path).fulfil(asked))
    assert not answer.good
    assert answer.text
    assert '\n' not in answer.text
    assert 'Error' not in answer.text
    assert not list(tmp_path.iterdir())


def test_what_a_node_refuses_comes_in_its_own_words(tmp_path):
    answer = asyncio.run(Actions(Link(), None, tmp_path).fulfil({'do': 'set', 'node': 'plant', 'values': {'mass': -1}}))
    assert answer == (False, 'plant refuses mass')


def test_saved_parameters_read_back_the_same_and_replace_no_file(tmp_path):
    present = {node: {name: list(value) if isinstance(value, tuple) else value for name, value in flatten(part).items()}
               for node, part in Configuration()._asdict().items()}
    present['plant']['paused'] = True
    present['position_controller']['backstepping.p'] = 0.1 + 0.2
    first, second = save_parameters(tmp_path, present), save_parameters(tmp_path, present)
    assert first != second
    read = load([first])
    assert read['position_controller']['backstepping.p'] == 0.1 + 0.2
    assert 'paused' not in read['plant']
    assert {node: set(values) for node, values in read.items()} == {
        node: set(values) - {'paused', 'hold_at'} for node, values in present.items()}
