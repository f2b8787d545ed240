"""The entries of parameters: those of nodes that describe themselves equal those of the declarations."""

from concurrent.futures import Future
from types import SimpleNamespace

import pytest
from rcl_interfaces.msg import FloatingPointRange, ListParametersResult, ParameterDescriptor, ParameterValue
from rcl_interfaces.msg import SetParametersResult as Result
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters

from mobile_robot_control.dashboard.parameter_book import ParameterBook, described_entry, known_entries, plain_value
from mobile_robot_control.dashboard.service_calls import NoAnswerError
from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.ros.shared.parameters import declare
from mobile_robot_control.settings.nodes import NODES

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


def test_a_parameter_of_another_package_has_what_its_node_tells_and_values_are_plain_json():
    descriptor = ParameterDescriptor(name='speed', type=3, description='of the robot [m/s]',
                                     additional_constraints='not too fast',
                                     floating_point_range=[FloatingPointRange(from_value=0.0, to_value=2.5)])
    entry = described_entry(descriptor, 1.0, {})
    assert (entry.text, entry.allowed, entry.low, entry.high) == ('of the robot [m/s]', 'not too fast', 0.0, 2.5)
    assert (entry.default, entry.slider, entry.live) == (None, (0.0, 2.5), True)
    for value, plain in (({'type': 3, 'double_value': float('nan')}, None),
                         ({'type': 8, 'double_array_value': [1.0, 2.5]}, [1.0, 2.5]),
                         ({'type': 4, 'string_value': '<b>\n'}, '<b>\\n'), ({'type': 5}, None)):
        assert plain_value(ParameterValue(**value)) == plain


class Graph:
    """Stands for a graph with a plant of one parameter, and for the calls to it, which are answered by hand."""

    def __init__(self):
        self.asked = []

    @staticmethod
    def resolve_topic_name(topic):
        return topic

    @staticmethod
    def get_publishers_info_by_topic(topic):
        return [SimpleNamespace(endpoint_gid=[1], node_name='plant', node_namespace='/')] if topic == 'odom' else []

    def prepare(self, kind, name):
        """Need no preparation."""

    def call(self, kind, name, request):
        self.asked.append((kind, Future()))
        return self.asked[-1][1]

    def answer(self, kind, response):
        """Answer the oldest call, which is of this kind."""
        asked, done = self.asked.pop(0)
        assert asked is kind
        if isinstance(response, Exception):
            done.set_exception(response)
        else:
            done.set_result(response)


def _found(value):
    return GetParameters.Response(values=[ParameterValue(type=3, double_value=value)])


LISTED = ListParameters.Response(result=ListParametersResult(names=['mass']))


def _told(graph, book):
    """Let the plant tell of its parameter."""
    book.discover()
    graph.answer(ListParameters, LISTED)
    graph.answer(GetParameters, _found(1.0))
    mass = ParameterDescriptor(name='mass', type=3)
    graph.answer(DescribeParameters, DescribeParameters.Response(descriptors=[mass]))
    assert book.value('plant', 'mass') == 1.0


def test_a_node_whose_answer_was_lost_is_asked_again():
    graph = Graph()
    book = ParameterBook(graph, graph)
    book.discover()
    graph.answer(ListParameters, NoAnswerError('lost'))
    _told(graph, book)
    book.refresh()
    graph.answer(GetParameters, NoAnswerError('lost'))
    book.discover()
    graph.answer(ListParameters, LISTED)
    graph.answer(GetParameters, _found(2.0))
    assert book.value('plant', 'mass') == 2.0
    book.discover()
    assert not graph.asked


def test_a_change_is_answered_once_its_value_is_known():
    graph = Graph()
    book = ParameterBook(graph, graph)
    _told(graph, book)
    answer = book.set('plant', {'mass': 3.0})
    graph.answer(SetParameters, SetParameters.Response(results=[Result(successful=True)]))
    assert not answer.done()
    graph.answer(GetParameters, _found(3.0))
    assert (answer.result(), book.value('plant', 'mass')) == ('', 3.0)
