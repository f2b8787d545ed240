"""What a page asks for is checked, whatever it sends, and answered in words."""

import asyncio
import math
from concurrent.futures import Future

import pytest

from mobile_robot_control.dashboard.actions import Actions
from mobile_robot_control.dashboard.publishing import SketchPoint, sketch_poses
from mobile_robot_control.dashboard.recordings import save_parameters
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import Configuration


class Graph:
    """Stands for a link to a graph on which no node has told its parameters, and for their book."""

    def __init__(self):
        self.book, self.nodes = self, {}

    @staticmethod
    def set(node, values):
        done = Future()
        done.set_result(f'{node} refuses {", ".join(map(str, values))}')
        return done

    @staticmethod
    def submit(job):
        done = Future()
        try:
            result = job()
            done.set_result(result.result() if isinstance(result, Future) else result)
        except Exception as error:
            done.set_exception(error)
        return done

    @staticmethod
    def start(present):
        raise OSError('no room')


def test_a_request_without_sense_is_refused_in_words(tmp_path):
    for asked in (
            None, 3, [], {}, {'do': 'format'}, {'do': ['set']}, {'do': []}, {'do': {}}, {'do': 'set'},
            {'do': 'set', 'node': 1, 'values': {'a': 1}}, {'do': 'set', 'node': 'plant', 'values': {}},
            {'do': 'set', 'node': 'plant', 'values': dict.fromkeys(range(51))}, {'do': 'set', 'values': 'x'},
            {'do': 'disturb'}, {'do': 'disturb', 'key': 'Enter'}, {'do': 'disturb', 'key': {}}, {'do': 'curve'},
            {'do': 'reset', 'pose': 'here'}, {'do': 'save'}, {'do': 'record', 'name': '../..'}):
        answer = asyncio.run(Actions(Graph(), Graph, tmp_path).fulfil(asked))
        assert not answer.good, asked
        assert answer.text
        assert '\n' not in answer.text
        assert 'Error' not in answer.text
        assert not list(tmp_path.iterdir())
    # what a node refuses comes in its own words
    asked = {'do': 'set', 'node': 'plant', 'values': {'mass': -1}}
    answer = asyncio.run(Actions(Graph(), None, tmp_path).fulfil(asked))
    assert answer == (False, 'plant refuses mass')


def test_pages_set_parameters_one_after_another(tmp_path):
    pending = []

    class Slow(Graph):
        """Answers later."""

        def submit(self, job):
            pending.append(Future())
            return pending[-1]

    async def ask():
        actions = Actions(Slow(), None, tmp_path)
        asked = [asyncio.create_task(actions.fulfil({'do': 'set', 'node': 'plant', 'values': {'mass': n}}))
                 for n in range(3)]
        for n in range(3):
            for _ in range(20):
                await asyncio.sleep(0.0)
            assert len(pending) == n + 1
            pending[n].set_result('')
        assert all(await asyncio.gather(*asked))

    asyncio.run(ask())


def test_saved_parameters_read_back_the_same_and_replace_no_file(tmp_path):
    present = {node: {name: list(value) if isinstance(value, tuple) else value for name, value in flatten(part).items()}
               for node, part in Configuration()._asdict().items()}
    present['plant']['paused'] = True
    present['position_controller']['backstepping.p'] = 0.1 + 0.2
    first, second = save_parameters(tmp_path, present), save_parameters(tmp_path, present)
    assert first != second
    read = load([first])
    assert read['position_controller']['backstepping.p'] == 0.1 + 0.2
    assert {node: set(values) for node, values in read.items()} == {
        node: set(values) - {'paused', 'hold_at'} for node, values in present.items()}

@pytest.mark.parametrize(('marks', 'headings'), [
    (['', '', ''], [0.0, 0.785, 1.571]),
    # on the spot, and backwards from there on
    (['', 't', ''], [0.0, 0.0, 1.571, 1.571]),
    (['', '', 'b'], [0.0, 0.0, -1.571, -1.571]),
    (['', 'b', 'b'], [3.142, -2.356, -1.571]),
])
def test_a_drawn_path_has_the_headings_of_its_marks(marks, headings):
    drawn = [SketchPoint(*point, mark) for point, mark in zip([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], marks, strict=True)]
    found = [math.remainder(pose.heading - heading, 2.0 * math.pi)
             for pose, heading in zip(sketch_poses(drawn), headings, strict=True)]
    assert found == pytest.approx([0.0] * len(headings), abs=1e-3)
