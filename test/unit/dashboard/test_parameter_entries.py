"""The entries of parameters: those of nodes that describe themselves equal those of the declarations."""

import pytest
from rcl_interfaces.msg import ParameterDescriptor, ParameterValue

from mobile_robot_control.dashboard.parameter_entries import described_entry, known_entries, plain_value
from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.parameters.nodes import NODES
from mobile_robot_control.ros.parameter_bridge import _descriptor

TYPES = {bool: 1, int: 2, float: 3, str: 4, tuple: 8}


@pytest.mark.parametrize('node', NODES)
def test_what_a_node_describes_is_what_it_declares(node):
    ours = known_entries(node)
    for name, declared in declarations(NODES[node]).items():
        descriptor = _descriptor(declared)
        descriptor.name, descriptor.type = name, TYPES[declared.kind]
        assert described_entry(descriptor, declared.default, ours) == ours[name]._replace(
            # a node does not tell a text's choices where they are none
            choices=ours[name].choices)


def test_a_parameter_of_another_package_has_what_its_node_tells():
    descriptor = ParameterDescriptor(name='speed', type=3, description='of the robot [m/s]',
                                     additional_constraints='above 0.0 m/s, at most 2.5 m/s')
    entry = described_entry(descriptor, 1.0, {})
    assert (entry.unit, entry.text, entry.low, entry.high) == ('m/s', 'of the robot', 0.0, 2.5)
    assert (entry.default, entry.slider, entry.live) == (None, (0.0, 2.5), True)


def test_the_values_are_plain_json():
    assert plain_value(ParameterValue(type=3, double_value=float('nan'))) is None
    assert plain_value(ParameterValue(type=8, double_array_value=[1.0, 2.5])) == [1.0, 2.5]
    assert plain_value(ParameterValue(type=4, string_value='<b>\n')) == '<b>\\n'
    assert plain_value(ParameterValue(type=5)) is None
