"""The files for ROS desktop tools agree with the nodes: frames, joints, topics, fields, sizes."""

import importlib
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import yaml

from mobile_robot_control.model.robot import Robot
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import LOOP_TOPICS, LOOPS, WHEEL_JOINTS

ROOT = Path(__file__).parents[2]
DESKTOP, LAUNCH = ROOT / 'config' / 'desktop', ROOT / 'launch'
# how many numbers an attribute has
NUMBERS = {'xyz': 3, 'rpy': 3, 'size': 3, 'rgba': 4} | dict.fromkeys(
    ('radius', 'length', 'value', 'ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'), 1)
# URDF 1.0: children that an element may have, attributes that it must and that it may have
URDF = {tag: [set(words.split()) for words in rule.split('|')] for tag, rule in {
    'robot': 'material link joint|name|', 'link': 'inertial visual collision|name|',
    'joint': 'origin parent child axis limit|name type|', 'inertial': 'origin mass inertia||',
    'visual': 'origin geometry material||', 'geometry': 'box cylinder sphere||', 'material': 'color|name|',
    'origin': '||xyz rpy', 'axis': '|xyz|', 'parent': '|link|', 'child': '|link|', 'mass': '|value|',
    'color': '|rgba|', 'inertia': '|ixx ixy ixz iyy iyz izz|', 'box': '|size|', 'cylinder': '|radius length|',
    'sphere': '|radius|'}.items()}


def _parse(name, folder=DESKTOP):
    return ElementTree.fromstring((folder / name).read_text(encoding='utf-8'))  # noqa: S314 (our own file)


def test_the_urdf_is_valid():
    robot = _parse('robot.urdf')
    for element in robot.iter():
        children, needed, allowed = URDF[element.tag]
        assert {child.tag for child in element} <= children
        assert needed <= set(element.attrib) <= needed | allowed
        for name, text in element.attrib.items():
            values = [float(part) for part in text.split()] if name in NUMBERS else []
            assert len(values) == NUMBERS.get(name, 0)
            assert all(map(math.isfinite, values))
        assert element.tag != 'joint' or element.get('type') in {'fixed', 'continuous'}
        assert element.tag != 'geometry' or len(element) == 1
    links = {link.get('name') for link in robot.iter('link')}
    children = [joint.find('child').get('link') for joint in robot.iter('joint')]
    parents = {joint.find('parent').get('link') for joint in robot.iter('joint')}
    # a tree of one root
    assert len(children) == len(set(children)) == len(links) - 1
    assert {*children, *parents} <= links
    assert {used.get('name') for used in robot.findall('link/visual/material')} <= {
        material.get('name') for material in robot.findall('material')}


def test_the_urdf_has_the_default_robot_parameters():
    robot, parameters = _parse('robot.urdf'), Robot()
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


def test_the_plotjuggler_layout_names_existing_fields():
    layout = _parse('plotjuggler.xml')
    names = [curve.get(key) for curve in layout.iter('curve')
             for key in (('curve_x', 'curve_y') if curve.get('curve_x') else ('name',))]
    assert {name.split('/')[1] for name in names} == set(LOOP_TOPICS)
    for name in names:
        _, topic, *path = name.split('/')
        package, _, kind = LOOP_TOPICS[topic].kind.split('/')
        value = getattr(importlib.import_module(f'{package}.msg'), kind)()
        if kind == 'JointState':
            assert path.pop(0) in WHEEL_JOINTS
        for field in path:
            value = getattr(value, field)
        assert kind == 'JointState' or isinstance(value, float)


def test_the_rviz_view_names_existing_topics_and_frames():
    view = yaml.safe_load((DESKTOP / 'robot.rviz').read_text(encoding='utf-8'))['Visualization Manager']
    assert view['Global Options']['Fixed Frame'] == Shared().odom_frame_id
    topics = {display['Topic']['Value']: display for display in view['Displays'] if 'Topic' in display}
    assert set(topics) == {'/odom', '/reference', '/reference_path'}
    assert topics['/reference_path']['Topic']['Durability Policy'] == 'Transient Local'
    assert {display['Class'].split('/')[0] for display in view['Displays']} == {'rviz_default_plugins'}


def test_the_launch_file_starts_the_four_nodes_from_one_file():
    launch = _parse('robot.launch.xml', LAUNCH)
    ours = [node for node in launch.findall('node') if node.get('pkg') == 'mobile_robot_control']
    assert {node.get('exec') for node in ours} == set(NODES)
    # a <param from=...> whose file does not exist is left out with a warning, and nodes drive with defaults
    assert {node.get('ros_args') for node in ours} == {'--params-file $(var params)'}
    share = '$(find-pkg-share mobile_robot_control)/'
    named = [part.split('"')[0].split("'")[0].split(')')[0]
             for part in (LAUNCH / 'robot.launch.xml').read_text(encoding='utf-8').split(share)[1:]]
    assert len(named) > 2
    assert all((ROOT / file).is_file() for file in named)


def test_the_launch_file_of_a_real_robot_starts_its_nodes_on_the_wall_clock():
    launch = _parse('real_robot.launch.xml', LAUNCH)
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
    text = (LAUNCH / 'real_robot.launch.xml').read_text(encoding='utf-8')
    assert set(re.findall(r'var (\w+)', text)) == arguments
