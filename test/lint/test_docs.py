"""The pages in docs/ agree with the code: topics and parameters of the nodes, links."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from mobile_robot_control.parameters.nodes import NODES
from mobile_robot_control.reporting.parameter_table import insert_parameters, tables

DOCS = Path(__file__).parents[2] / 'docs'
PAGES = {path.stem: path.read_text(encoding='utf-8') for path in (DOCS / 'nodes').glob('*.md')}


def test_there_is_a_page_for_each_node():
    assert set(PAGES) == set(NODES)


@pytest.mark.parametrize('node', NODES)
def test_its_parameters_are_present(node):
    assert insert_parameters(PAGES[node]) == PAGES[node]
    assert tables(node) in PAGES[node]


def test_its_topics_are_those_of_the_node(domain):
    code = (
        'import rclpy\n'
        'from mobile_robot_control.ros.spin import make_node\n'
        'from mobile_robot_control.parameters.nodes import NODES\n'
        'rclpy.init()\n'
        'for name in NODES:\n'
        '    node = make_node(name)\n'
        '    for verb, found in (("publishes", node.publishers), ("subscribes", node.subscriptions)):\n'
        '        for end in found:\n'
        '            kind = end.msg_type.__module__.split(".")[0] + "/msg/" + end.msg_type.__name__\n'
        '            print(name, end.topic_name, kind, verb)\n'
    )
    told = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, timeout=60, check=True).stdout
    for node, page in PAGES.items():
        real = {tuple(line.split()[1:]) for line in told.splitlines() if line.split()[0] == node}
        real = {topic for topic in real if topic[0] not in ('/rosout', '/parameter_events', '/tf')}
        written = {('/' + topic.lstrip('/'), kind, verb)
                   for topic, kind, verb in re.findall(r'^\| `(\S+)` \| `(\S+)` \| (\w+) \|$', page, re.MULTILINE)}
        assert written == real


@pytest.mark.parametrize('path', [*DOCS.rglob('*.md'), DOCS.parent / 'README.md'], ids=lambda path: path.name)
def test_links_lead_somewhere(path):
    for target in re.findall(r'\]\(([^)#]+)\)', path.read_text(encoding='utf-8')):
        assert target.startswith('http') or (path.parent / target).exists(), target


def test_parameters_named_in_a_page_exist():
    """What stands in a page as `name.part` or in a YAML block is a parameter."""
    known = tables()
    for name in re.findall(r'`((?:limits|fuzzy|gains|robot|backstepping|hybrid_backstepping)\.\w+)`',
                           ' '.join(PAGES.values())):
        assert f'`{name}`' in known
