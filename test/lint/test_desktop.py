"""The files for ROS desktop tools agree with the nodes: frames, joints, topics, fields, sizes."""

import importlib
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.configuration.shared import Shared
from mobile_robot_control.messages.parsing import WHEEL_JOINTS
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.topics import LOOP_TOPICS, LOOPS

DESKTOP = Path(__file__).parents[2] / 'config' / 'desktop'
# how many numbers an attribute has
NUMBERS = {'xyz': 3, 'rpy': 3, 'size': 3, 'rgba': 4, 'radius': 1, 'length': 1, 'value': 1, 'ixx': 1, 'ixy': 1, 'ixz': 1,
           'iyy': 1, 'iyz': 1, 'izz': 1}
# URDF 1.0: children that an element may have, attributes that it must and that it may have
URDF = {
    'robot': ({'material', 'link', 'joint'}, {'name'}, set()),
    'link': ({'inertial', 'visual', 'collision'}, {'name'}, set()),
    'joint': ({'origin', 'parent', 'child', 'axis', 'limit'}, {'name', 'type'}, set()),
    'inertial': ({'origin', 'mass', 'inertia'}, set(), set()),
    'visual': ({'origin', 'geometry', 'material'}, set(), set()),
    'geometry': ({'box', 'cylinder', 'sphere'}, set(), set()),
    'material': ({'color'}, {'name'}, set()),
    'origin': (set(), set(), {'xyz', 'rpy'}), 'axis': (set(), {'xyz'}, set()),
    'parent': (set(), {'link'}, set()), 'child': (set(), {'link'}, set()),
    'mass': (set(), {'value'}, set()), 'color': (set(), {'rgba'}, set()),
    'inertia': (set(), {'ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'}, set()),
    'box': (set(), {'size'}, set()), 'cylinder': (set(), {'radius', 'length'}, set()),
    'sphere': (set(), {'radius'}, set()),
}
TYPES = {'fixed', 'continuous', 'revolute', 'prismatic', 'floating', 'planar'}


def parse(text):
    return ElementTree.fromstring(text)  # noqa: S314 (our own file)


def are_numbers(text, count):
    """Return whether a text is so many finite numbers."""
    try:
        values = [float(part) for part in text.split()]
    except ValueError:
        return False
    return len(values) == count and all(map(math.isfinite, values))


def schema_faults(element):
    """Yield what the URDF schema forbids in an element and its children."""
    children, needed, allowed = URDF.get(element.tag, (set(), set(), set()))
    if element.tag not in URDF:
        yield f'<{element.tag}> is unknown'
    for name in needed - set(element.attrib):
        yield f'<{element.tag}> lacks {name}'
    for name, value in element.attrib.items():
        if name not in needed | allowed:
            yield f'<{element.tag}> has an unknown {name}'
        if name in NUMBERS and not are_numbers(value, NUMBERS[name]):
            yield f'{name}="{value}" of <{element.tag}>'
    if element.tag == 'joint' and element.get('type') not in TYPES:
        yield f'joint of type {element.get("type")}'
    if element.tag == 'geometry' and len(element) != 1:
        yield 'a geometry has one shape'
    for child in element:
        if child.tag not in children:
            yield f'<{child.tag}> in <{element.tag}>'
        yield from schema_faults(child)


def tree_faults(robot):
    """Yield links with no parent or two, joints between missing links, and materials that are not declared."""
    links = {link.get('name') for link in robot.iter('link')} - {None}
    children = [joint.find('child').get('link') for joint in robot.iter('joint')]
    parents = [joint.find('parent').get('link') for joint in robot.iter('joint')]
    yield from (f'no link {name}' for name in {*children, *parents} - links)
    yield from (f'{name} has two parents' for name in children if children.count(name) > 1)
    roots = links - set(children)
    if len(roots) != 1:
        yield f'roots {roots}'
    known = {material.get('name') for material in robot.findall('material')}
    yield from (f'no material {used.get("name")}' for used in robot.findall('link/visual/material')
                if used.get('name') not in known)


@pytest.fixture
def urdf():
    return (DESKTOP / 'robot.urdf').read_text(encoding='utf-8')


def test_the_urdf_is_valid(urdf):
    robot = parse(urdf)
    assert not list(schema_faults(robot))
    assert not list(tree_faults(robot))


def test_the_urdf_has_the_default_robot_parameters(urdf):
    robot, parameters = parse(urdf), Robot()
    joints = {joint.get('name'): joint for joint in robot.iter('joint')}
    assert set(WHEEL_JOINTS) <= set(joints)
    for name, side in zip(WHEEL_JOINTS, (-1.0, 1.0), strict=True):
        offset = [float(part) for part in joints[name].find('origin').get('xyz').split()]
        assert offset == [0.0, side * 0.5 * parameters.wheel_separation, 0.0]
        # a positive angle rolls forwards
        assert joints[name].find('axis').get('xyz') == '0 1 0'
        assert joints[name].get('type') == 'continuous'
    radii = [float(shape.get('radius')) for shape in robot.iter('cylinder')]
    assert radii == [parameters.wheel_radius] * 2
    assert float(robot.find('link/inertial/mass').get('value')) == parameters.mass
    assert float(robot.find('link/inertial/inertia').get('izz')) == parameters.inertia
    assert float(robot.find('link/inertial/origin').get('xyz').split()[0]) == parameters.com_offset
    assert robot.find('link').get('name') == Shared().base_frame_id


def _value(topic, path):
    """Follow a PlotJuggler series name through a message of the topic's type."""
    package, _, kind = LOOP_TOPICS[topic].kind.split('/')
    message = getattr(importlib.import_module(f'{package}.msg'), kind)()
    if LOOP_TOPICS[topic].kind == 'sensor_msgs/msg/JointState':
        joint, field = path
        assert joint in WHEEL_JOINTS
        return getattr(message, field)
    for name in path:
        message = getattr(message, name)
    assert isinstance(message, float)
    return message


def test_the_plotjuggler_layout_names_existing_fields():
    layout = parse((DESKTOP / 'plotjuggler.xml').read_text(encoding='utf-8'))
    names = [curve.get(key) for curve in layout.iter('curve')
             for key in (('curve_x', 'curve_y') if curve.get('curve_x') else ('name',))]
    assert {name.split('/')[1] for name in names} == set(LOOP_TOPICS)
    for name in names:
        _, topic, *path = name.split('/')
        _value(topic, path)


def test_the_rviz_view_names_existing_topics_and_frames():
    view = yaml.safe_load((DESKTOP / 'robot.rviz').read_text(encoding='utf-8'))['Visualization Manager']
    assert view['Global Options']['Fixed Frame'] == Shared().odom_frame_id
    topics = {display['Topic']['Value']: display for display in view['Displays'] if 'Topic' in display}
    assert set(topics) == {'/odom', '/reference', '/reference_path'}
    assert topics['/reference_path']['Topic']['Durability Policy'] == 'Transient Local'
    assert {display['Class'].split('/')[0] for display in view['Displays']} == {'rviz_default_plugins'}


def test_the_launch_file_starts_the_four_nodes_from_one_file():
    launch = parse((DESKTOP / 'robot.launch.xml').read_text(encoding='utf-8'))
    ours = [node for node in launch.findall('node') if node.get('pkg') == 'mobile_robot_control']
    assert {node.get('exec') for node in ours} == set(NODES)
    # a <param from=...> whose file does not exist is left out with a warning, and nodes drive with defaults
    assert {node.get('ros_args') for node in ours} == {'--params-file $(var params)'}
    share = '$(find-pkg-share mobile_robot_control)/'
    named = [part.split('"')[0].split("'")[0].split(')')[0]
             for part in (DESKTOP / 'robot.launch.xml').read_text(encoding='utf-8').split(share)[1:]]
    assert len(named) > 2
    assert all((DESKTOP.parents[1] / file).is_file() for file in named)


def test_the_launch_file_of_a_real_robot_starts_its_nodes_on_the_wall_clock():
    launch = parse((DESKTOP / 'real_robot.launch.xml').read_text(encoding='utf-8'))
    nodes = {node.get('exec'): node for node in launch.findall('node')}
    assert list(nodes) == ['position_controller', 'velocity_controller', 'reference_cart']
    assert [name for name, node in nodes.items() if node.get('if')] == ['velocity_controller']
    arguments = {argument.get('name') for argument in launch.findall('arg')}
    for name, node in nodes.items():
        values = {one.get('name'): one.get('value') for one in node.findall('param')}
        assert values == {'lockstep': 'false', 'use_sim_time': '$(var use_sim_time)'}
        assert (node.get('name'), node.get('ros_args')) == (name, '--params-file $(var params)')
        inputs = {topic for loop in LOOPS.values() for topic in loop.topics_of(name)}
        assert {one.get('from') for one in node.findall('remap')} == inputs & {'odom', 'cmd_vel'}
    text = (DESKTOP / 'real_robot.launch.xml').read_text(encoding='utf-8')
    assert set(re.findall(r'var (\w+)', text)) == arguments
