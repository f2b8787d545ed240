"""YAML that rcl refuses or reads in another way is refused with line and remedy; all else is read alike."""


import pytest
import rclpy
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.parameters.rcl_yaml import as_rcl, dump_yaml, parse_yaml
from mobile_robot_control.ros.start.arguments import check_ros_arguments
from mobile_robot_control.settings.files import load, read_override

WORDS = ['y', 'N', 'yes', 'off', 'tRue', '~', 'null', 'a text', '.', '2001-01-01', '=', '<<']
NUMBERS = ['5', '+5', '-7', '0', '08', '017', '0o17', '1_0', '0b11', '0x1F', '0X1f', '0x', '0x1p3', '0x.8',
           '1e5', '1e-3', '1.e5', '.5', '5.', '1_0.5', '1e400', '1e-310', '0e-400', '2.2250738585072014e-308', 'inf',
           '-inf', '.inf', '+.INF', '.Infinity', '.nan', '.NaN', '.nAn', '+.nan', '-nan', 'nan(1)',
           '9223372036854775807', '9223372036854775808', '-9223372036854775809',
           '0777777777777777777777', '0xfffffffffffffffff', '9' * 400]
DIFFERENT = ['1_0', '0b11', '1:40', 'y', 'n', '08', 'inf', 'nan', '0x1p3', '1e400', '1e-310', '2001-01-01']


def _refusal(text):
    with pytest.raises(ParameterError) as refused:
        parse_yaml(text, 'here')
    violation, = refused.value.violations
    assert violation.isprintable()
    return violation


def test_a_text_without_quotes_is_what_rcl_reads(domain, tmp_path):
    file = tmp_path / 'all.yaml'
    texts = WORDS + NUMBERS
    file.write_text('/**:\n  ros__parameters:\n' + ''.join(f'    v{n}: {text}\n' for n, text in enumerate(texts)))
    rclpy.init(args=['--ros-args', '--params-file', str(file)], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node('reader', automatically_declare_parameters_from_overrides=True, enable_rosout=False)
        found = {text: node.get_parameter(f'v{n}').value for n, text in enumerate(texts)}
        node.destroy_node()
    finally:
        rclpy.try_shutdown()
    assert {text: repr(value) for text, value in found.items()} == {text: repr(as_rcl(text)) for text in texts}


@pytest.mark.parametrize('text', DIFFERENT)
def test_what_rcl_reads_in_another_way_is_refused_by_nodes_and_commands_in_the_same_words(tmp_path, text):
    file = tmp_path / 'odd.yaml'
    file.write_text(f'/**:\n  ros__parameters:\n    robot.mass: {text}\n')
    with pytest.raises(ParameterError) as by_command:
        load([file])
    with pytest.raises(ParameterError) as by_node:
        check_ros_arguments(['plant'], ['--ros-args', '--params-file', str(file)])
    assert by_command.value.violations == by_node.value.violations
    assert f"{file}, line 3: '{text}' is" in str(by_node.value)
    assert 'in quotes' in str(by_node.value)
    with pytest.raises(ParameterError, match='in quotes'):
        read_override(f'plant.robot.mass:={text}')


@pytest.mark.parametrize(('text', 'reason'), [
    ('/**:\n  ros__parameters: &a {x: 1}\n', 'line 2: the anchor &a'),
    ('x: [&a 1, *a]', 'the anchor &a'), ('x: *a', 'the alias *a'), ('&a [*a]', 'the anchor &a'),
    ('%YAML 1.1\n---\nx: 1', 'line 1: a directive'), ('%TAG ! tag:a,2000:\n---\nx: 1', 'a directive'),
    ('%ODD\n---\nx: 1', 'a directive'),
    ('x: !!str 5', 'the tag'), ('x: !!python/object:os.system 5', 'the tag'), ('x: ! 5', 'the tag !'),
    ('x: 1\nx: 2', "line 2: 'x' is written twice"), ('x: [[1]]', 'an array contains'), ('x: [{a: 1}]', 'an array'),
    ('? [a]\n: 5', 'a name is no text'), ('x: |-\n  5\n', "'5' is 5 for nodes"), ('x: 1\n---\nx: 2', 'here'),
    ('[' * 10_000, 'nested more than'), ('{a: ' * 10_000, 'nested more than'), ('- ' * 3000 + '1', 'nested more than'),
    ('x: ' + '1:' * 5000 + '1', 'here'), ('\x00', 'here'), ('x: \x1b', 'here'), ('x: 2001-99-99', 'here'),
])
def test_what_rcl_does_not_take_is_refused_with_the_place(text, reason):
    assert reason in _refusal(text)


def test_names_are_texts_whatever_they_look_like():
    assert parse_yaml('{1_0: 1, y: 2, "3": 4, null: 5}', 'here') == {'1_0': 1, 'y': 2, '3': 4, 'null': 5}


@pytest.mark.parametrize('text', [*WORDS, *NUMBERS, 'one\ntwo', '', ' a', '\x85', '*a', '&a', '!a', '%a'])
def test_a_written_text_is_read_back_as_a_text_by_us_and_by_rcl(text):
    written = dump_yaml({'x': text, 'list': [text]})
    assert parse_yaml(written, 'here') == {'x': text, 'list': [text]}
    plain = written.partition(': ')[2].partition('\n')[0]
    assert plain[0] in '"\'' or as_rcl(plain) == text


def test_a_list_that_occurs_twice_is_written_twice():
    pose = [1.0, 2.0]
    assert parse_yaml(dump_yaml({'a': pose, 'b': pose}), 'here') == {'a': pose, 'b': pose}
