"""`--node NAME=COMMAND`: what is read and refused, the checksum, and which command repeats a recorded one."""

import json
import sys

import pytest

from mobile_robot_control.experiment import command as experiment
from mobile_robot_control.experiment.foreign_nodes import (
    ForeignNode,
    foreign_nodes,
    read_node,
    recorded_nodes,
    replay_faults,
)
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.topics import LOOPS

PYTHON = sys.executable


def test_a_command_is_read_into_words():
    assert read_node("plant=ros2 run a b --name 'x y'") == ('plant', ('ros2', 'run', 'a', 'b', '--name', 'x y'))


@pytest.mark.parametrize(('given', 'told'), [
    ('robot=x', "'robot' is none of the nodes; take one of plant, "), ('plant', 'write NAME=COMMAND'),
    ('plant=', 'write NAME=COMMAND'), ("plant=a 'b", 'close the quotation marks'),
    ('plant=no_such_program', "--node plant: there is no program 'no_such_program'; write its path, or install it")])
def test_what_cannot_be_started_is_refused_before_a_folder_is_made(tmp_path, capsys, given, told):
    words = ['--duration', '1', '--output', str(tmp_path / 'out'), '--node', given]
    try:
        code = experiment.main(words)
    except SystemExit as ended:
        code = ended.code
    assert code == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()


def test_a_name_counts_once_and_only_in_its_loop():
    command = ('velocity_controller', (PYTHON,))
    with pytest.raises(ParameterError, match='velocity_controller is given twice'):
        foreign_nodes([command, command], (), LOOPS['torque'])
    with pytest.raises(ParameterError, match='velocity_controller is no node of a loop'):
        foreign_nodes([command], (), LOOPS['velocity'])


def test_the_checksum_is_of_the_words_and_of_the_files_that_they_name(tmp_path):
    script = tmp_path / 'node.py'
    script.write_text('1')

    def node(*words):
        return foreign_nodes([('plant', (PYTHON, str(script), *words))], (), LOOPS['torque'])['plant']

    first = node()
    assert node() == first
    assert node('-v').sha256 != first.sha256
    script.write_text('2')
    assert node().words == first.words
    assert node().sha256 != first.sha256


def test_a_replay_needs_the_same_name_command_and_checksum():
    recorded = {'plant': {'command': 'a b', 'sha256': '12', 'flow_control': False}}
    assert replay_faults(recorded, {'plant': ForeignNode(('a', 'b'), '12')}) == []
    for before, given, told in (
            (recorded, {}, "plant was the command a b (SHA-256 12...); add --node 'plant=a b'"),
            (recorded, {'plant': ForeignNode(('a', 'b'), '13')}, 'is another one now; bring that back'),
            ({}, {'plant': ForeignNode(('a',), '13')}, 'plant was the node of this package; leave --node plant'),
            ({'plant': {'attached': True}}, {}, 'which no replay can start again'), ({'plant': 3}, {}, 'plant was')):
        fault, = replay_faults(before, given)
        assert told in fault


def test_the_nodes_of_a_folder_are_those_of_its_provenance(tmp_path):
    assert recorded_nodes(tmp_path) == {}
    for content, nodes in (({'provenance': {'nodes': {'plant': {}}}}, {'plant': {}}), ([], {}), ({'provenance': 3}, {}),
                           ({'provenance': {'nodes': 3}}, {})):
        (tmp_path / 'metrics.json').write_text(json.dumps(content))
        assert recorded_nodes(tmp_path) == nodes


def test_an_attached_robot_does_not_move_without_yes_and_cannot_begin_again(tmp_path, capsys):
    words = ['--duration', '4', '--output', str(tmp_path / 'out'), '--attach', 'plant']
    assert experiment.main(words) == 0
    assert capsys.readouterr().out.startswith(
        'would drive the robot for 4 s along the trifolium of 1 m, 16 s a lap; clear that floor')
    for option in ('--compare', '--replay'):
        assert experiment.main([*words, option, 'x']) == 2
        assert f'{option} is not allowed with --attach' in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()
