"""The entries of parameters: those of nodes that describe themselves equal those of the declarations."""

import pytest
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, ParameterValue

from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.dashboard.parameter_book import described_entry, known_entries, plain_value
from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.ros.services.parameter_bridge import declare

TYPES = {bool: 1, int: 2, float: 3, str: 4, list: 8}


class Declared:
    """Stands for a node: keeps the descriptors of what is declared on it."""

    def __init__(self):
        self._parameter_overrides = {}
        self.descriptors = {}

    def declare_parameter(self, name, value, descriptor, ignore_override):
        """Keep a descriptor, named and typed as rclpy does it."""
        descriptor.name, descriptor.type = name, TYPES[list if isinstance(value, list) else type(value)]
        self.descriptors[name] = descriptor


@pytest.mark.parametrize('node', NODES)
def test_what_a_node_describes_is_what_it_declares(node):
    ours, stand_in = known_entries(node), Declared()
    declare(stand_in, NODES[node])
    for name, declared in declarations(NODES[node]).items():
        assert described_entry(stand_in.descriptors[name], declared.default, ours) == ours[name]


def test_a_parameter_of_another_package_has_what_its_node_tells():
    descriptor = ParameterDescriptor(name='speed', type=3, description='of the robot [m/s]',
                                     additional_constraints='not too fast',
                                     floating_point_range=[FloatingPointRange(from_value=0.0, to_value=2.5)])
    entry = described_entry(descriptor, 1.0, {})
    assert (entry.text, entry.allowed, entry.low, entry.high) == ('of the robot [m/s]', 'not too fast', 0.0, 2.5)
    assert (entry.default, entry.slider, entry.live) == (None, (0.0, 2.5), True)


def test_the_values_are_plain_json():
    assert plain_value(ParameterValue(type=3, double_value=float('nan'))) is None
    assert plain_value(ParameterValue(type=8, double_array_value=[1.0, 2.5])) == [1.0, 2.5]
    assert plain_value(ParameterValue(type=4, string_value='<b>\n')) == '<b>\\n'
    assert plain_value(ParameterValue(type=5)) is None
