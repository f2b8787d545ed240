"""The SROS2 policy: made from the table of topics, valid by sros2's schema, one enclave a node."""

from pathlib import Path

import pytest
from helpers.policy_reading import allowed, faults

from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.settings.sros2_policy import policy, write_policy
from mobile_robot_control.topics import LOOP_TOPICS, LOOPS

SHIPPED = Path(__file__).parents[3] / 'config' / 'sros2' / 'policy.xml'
ROOM = '/mobile_robot_control'


def test_the_shipped_file_is_the_one_that_make_pages_writes(tmp_path):
    assert write_policy([str(tmp_path / 'policy.xml')]) == 0
    assert SHIPPED.read_bytes() == (tmp_path / 'policy.xml').read_bytes()


@pytest.mark.parametrize(('before', 'after'), [
    ('version="0.2.0"', 'version="0.1.0"'), ('publish="ALLOW"', 'publish="allow"'), ('publish="', 'call="'),
    ('<topic>odom</topic>', '<service>odom</service>'), ('<topic>odom</topic>', '<topic></topic>'),
    ('<topic>odom</topic>', '<name>odom</name>'), (' node="plant"', ''), ('<enclaves>', '<enclaves/><enclaves>'),
    ('</profile>', '<topics publish="ALLOW"></topics></profile>'),
])
def test_the_policy_is_valid_and_a_file_that_breaks_the_schema_is_found(before, after):
    assert not any(list(faults(policy(namespace))) for namespace in ('/', '/robot1', '/fleet/robot1'))
    assert list(faults(policy().replace(before, after)))


def test_each_node_has_an_enclave_and_experiment_has_one_for_all():
    enclaves = allowed(policy('/robot1'))
    room = f'{ROOM}/robot1'
    assert set(enclaves) == {*(f'{room}/{node}' for node in NODES), f'{room}/experiment'}
    together = enclaves.pop(f'{room}/experiment')
    assert set(together) == {*(f'/robot1/{node}' for node in NODES), '/robot1/recorder', '/robot1/replayer'}
    for path, nodes in enclaves.items():
        (name, rules), = nodes.items()
        assert (name, rules) == (f'/robot1/{path.rpartition("/")[2]}', together[name])


@pytest.mark.parametrize('topic', LOOP_TOPICS.values())
def test_a_loop_topic_is_published_by_its_publisher_alone_and_read_by_its_subscribers(topic):
    rules = allowed(policy())[f'{ROOM}/experiment']
    assert [node for node in rules if ('publish', f'/{topic.name}') in rules[node]] == [f'/{topic.publisher}']
    # where a run stalls, the plant looks for the answer that is missing
    answers = {answer for loop in LOOPS.values() for _, answer in loop.answers}
    stalled = {'/plant'} if topic.name in answers else set()
    # a controller listens to another one of its name
    beside = {'/position_controller'} if topic.name == 'cmd_vel' else set()
    assert {node for node in rules if ('subscribe', f'/{topic.name}') in rules[node]} == stalled | beside | {
        '/recorder', *(f'/{node}' for loop in LOOPS.values() if topic.name in loop.topics
                       for node in loop.topics[topic.name].subscribers)}


def test_nodes_serve_under_their_own_names_and_those_of_experiment_alone_call():
    rules = allowed(policy())[f'{ROOM}/experiment']
    for node, found in rules.items():
        assert all(name.startswith(f'{node}/') for verb, name in found if verb == 'reply')
    assert {(node, name) for node, found in rules.items() for verb, name in found if verb == 'request'} == {
        ('/recorder', '/plant/set_parameters'), ('/replayer', '/plant/reset'),
        *(('/replayer', f'/{node}/set_parameters_atomically') for node in NODES)}


@pytest.mark.parametrize(('arguments', 'reason'), [
    ([], 'give a file'), (['policy.xml', '/', 'more'], 'give a file'),
    (['policy.xml', 'robot1'], "'robot1' is no namespace of ROS"), (['policy.xml', '/a"b'], 'is no namespace of ROS'),
    (['none/policy.xml'], "'none/policy.xml' cannot be written"),
])
def test_bad_usage_is_refused_and_nothing_is_written(tmp_path, monkeypatch, capsys, arguments, reason):
    monkeypatch.chdir(tmp_path)
    assert write_policy(arguments) == 2
    error, = capsys.readouterr().err.splitlines()
    assert error.startswith('sros2_policy: ')
    assert reason in error
    assert not list(tmp_path.iterdir())
