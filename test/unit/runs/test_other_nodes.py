"""Somebody else's nodes in the words of a run."""

from mobile_robot_control.runs.other_nodes import described_nodes, nodes_of_others
from mobile_robot_control.runs.words import run_sentence
from mobile_robot_control.settings.nodes import Configuration


def test_odd_provenance_tells_of_no_node():
    for nodes in (3, {'else': {}}, {'plant': 'x'}, None):
        assert nodes_of_others({'nodes': nodes}) == {}


def test_each_node_is_told_with_what_cannot_be_repeated():
    started, attached = {'command': 'a b', 'sha256': 'c' * 64, 'flow_control': False}, {'attached': True}
    first, second = described_nodes({'plant': started}, False)
    assert first.startswith('plant was the command a b (SHA-256 cccccccccccc...): the run can be repeated if')
    assert 'nothing held it for the recorder' in second
    assert [*described_nodes({'plant': attached}, False)] == [
        'plant was a node that ran already: the run cannot be replayed']
    assert 'neither its times nor its numbers can be repeated' in next(described_nodes({'plant': attached}, True))


def test_a_run_names_no_law_and_no_curve_of_ours_that_did_not_drive():
    told = run_sentence({'outcome': 'completed', 'duration': 1.0}, Configuration(),
                        others=['position_controller', 'reference_cart'])
    assert told.startswith('On the reference of another cart, another position controller completed')
