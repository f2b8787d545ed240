"""The last value given in ROS arguments takes effect in rcl, or the arguments are refused: none is ignored."""

import rclpy
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.ros.services.ros_arguments import check_ros_arguments

_NAMES = ('duration', 'peer_timeout')
_VALUES = st.sampled_from([1.0, 2.0, 3.0])
_REACHING = {'/': ['/**', '/**/plant', '/plant', 'plant', '/*'],
             '/robot1': ['/**', '/**/plant', '/robot1/plant', '/robot1/*']}
_RULE = st.tuples(st.sampled_from(['', '', 'plant:']), st.sampled_from(_NAMES), _VALUES)


def _file(namespace):
    sections = st.sampled_from([*_REACHING[namespace], '/elsewhere/plant_of_others'])
    values = st.dictionaries(st.sampled_from(_NAMES), _VALUES, min_size=1)
    return st.dictionaries(sections, values, min_size=1, max_size=3)


def _sources(namespace):
    return st.tuples(st.just(namespace), st.lists(st.one_of(_file(namespace), _RULE), min_size=1, max_size=4))


def _rcl_takes(arguments):
    rclpy.init(args=arguments)
    try:
        node = rclpy.create_node('plant', start_parameter_services=False,
                                 automatically_declare_parameters_from_overrides=True)
        values = {name: node.get_parameter(name).value for name in _NAMES if node.has_parameter(name)}
        node.destroy_node()
        return values
    finally:
        rclpy.shutdown()


def test_the_last_value_wins_or_is_refused(domain, tmp_path):
    outcomes = {True: 0, False: 0}

    @settings(max_examples=60)
    @example(('/', [{'/**': {'peer_timeout': 1.0}, '/**/plant': {'duration': 1.0}}, ('', 'duration', 2.0)]))
    @given(st.sampled_from(list(_REACHING)).flatmap(_sources))
    def fuzz(drawn):
        namespace, sources = drawn
        arguments, last = ['--ros-args', '-r', f'__ns:={namespace}'], {}
        for number, source in enumerate(sources):
            if isinstance(source, dict):
                file = tmp_path / f'{number}.yaml'
                tree = {name: {'ros__parameters': values} for name, values in source.items()}
                file.write_text(yaml.safe_dump(tree, sort_keys=False), encoding='utf-8')
                arguments += ['--params-file', str(file)]
                for section, values in source.items():
                    last.update(values if section in _REACHING[namespace] else {})
            else:
                node, name, value = source
                arguments += ['-p', f'{node}{name}:={value}']
                last[name] = value
        try:
            check_ros_arguments(['plant'], arguments)
        except ParameterError:
            outcomes[False] += 1
            # arguments that rcl would have applied as written are not refused
            if namespace == '/' or not any(isinstance(source, tuple) and source[0] for source in sources):
                assert _rcl_takes(arguments) != last
        else:
            assert _rcl_takes(arguments) == last
            outcomes[True] += 1

    fuzz()
    assert min(outcomes.values()) > 10
