"""The pages in docs/ agree with the code: parameters, topics, metrics, columns, options, numbers of decisions."""

import re
import subprocess
import sys
from pathlib import Path

import metric_tables
import pytest
from each import each
from parameter_table import insert_parameters, tables
from robots_table import insert_robots

from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.quantities import Pose, WheelTorque
from mobile_robot_control.recording.csv_table import CSV_COLUMNS
from mobile_robot_control.ros.services.condition import SUBSCRIBERS_KEY
from mobile_robot_control.simulation.indices import PerformanceIndices
from mobile_robot_control.simulation.metric_table import INDEX_METRICS, INDICES, RUN_METRICS
from mobile_robot_control.simulation.metrics import MeasuredRun, summary
from mobile_robot_control.simulation.scenarios import Scenario
from mobile_robot_control.simulation.totals import Totals
from mobile_robot_control.topics import ALL_LOOP_TOPICS
from mobile_robot_control.tuning.comparison import comparison_values
from mobile_robot_control.tuning.failures import failure_values
from mobile_robot_control.tuning.monte_carlo import METRICS, Judged, metric_labels, summarise_runs
from mobile_robot_control.tuning.search import Generation

DOCS = Path(__file__).parents[2] / 'docs'
PAGES = {path.stem: path.read_text(encoding='utf-8') for path in (DOCS / 'nodes').glob('*.md')}
COMMANDS = ('simulate', 'experiment', 'report', 'tune', 'study', 'benchmark', 'plan', 'excite', 'identify', 'dashboard')


def _page(name):
    return (DOCS / f'{name}.md').read_text(encoding='utf-8')


def _code(text):
    """All that stands between backticks."""
    return re.findall(r'`([^`]+)`', re.sub(r'^```.*?^```', '', text, flags=re.DOTALL | re.MULTILINE))


def test_there_is_a_page_for_each_node():
    assert set(PAGES) == set(NODES)


@each(NODES)
def test_the_table_of_its_parameters_is_present(node):
    assert insert_parameters(PAGES[node]) == PAGES[node]
    assert tables(node) in PAGES[node]


def test_the_table_of_all_parameters_is_present():
    page = _page('parameters')
    assert insert_parameters(page) == page
    assert tables() in page


def test_the_tables_of_all_robots_are_present():
    page = _page('robots')
    assert insert_robots(page) == page
    assert {file.stem for file in (DOCS.parent / 'config' / 'robots').iterdir()} == set(
        re.findall('^## (.+)$', page.partition('<!-- robots: generated -->')[2], re.MULTILINE))


def test_its_topics_are_those_of_the_node(domain):
    code = (
        'import rclpy\n'
        'from mobile_robot_control.ros.spin import make_node\n'
        'from mobile_robot_control.configuration.nodes import NODES\n'
        'rclpy.init()\n'
        'for name in NODES:\n'
        '    node = make_node(name)\n'
        '    for verb, found in (("publishes", node.publishers), ("subscribes", node.subscriptions)):\n'
        '        for end in found:\n'
        '            kind = end.msg_type.__module__.split(".")[0] + "/msg/" + end.msg_type.__name__\n'
        '            print(name, end.topic_name, kind, verb)\n'
        '    for end in node.services:\n'
        '        kind = end.srv_type.__module__.split(".")[0] + "/srv/" + end.srv_type.__name__\n'
        '        print(name, end.service_name, kind, "serves")\n'
    )
    printed = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, timeout=120,
                             check=True).stdout
    for node, page in PAGES.items():
        real = {tuple(line.split()[1:]) for line in printed.splitlines() if line.split()[0] == node}
        real = {end for end in real if end[0] not in ('/rosout', '/parameter_events', '/tf')
                and not end[1].startswith(('rcl_interfaces/srv', 'type_description_interfaces/srv'))}
        written = {('/' + topic.lstrip('/'), kind, verb)
                   for topic, kind, verb in re.findall(r'^\| `(\S+)` \| `(\S+)` \| (\w+) \|$', page, re.MULTILINE)}
        assert written == real


def test_the_topics_of_the_loop_are_those_of_the_table():
    loop = _page('topics').partition('## Topics of the loop')[2].partition('\n## ')[0]
    rows = [[cell.strip(' `') for cell in line.split('|')[1:-1]] for line in loop.splitlines()
            if line.startswith('| `')]
    assert [(row[0], row[1], row[3], row[4].replace(' ', '_')) for row in rows] == [
        (topic.name, topic.kind, topic.publisher, topic.rate) for topic in ALL_LOOP_TOPICS.values()]


def test_the_diagnostics_have_the_key_of_the_page():
    assert f'{SUBSCRIBERS_KEY}TOPIC' in _code(_page('topics'))


def test_parameters_named_in_a_page_exist():
    """What stands in a page as `group.name` or `node.name` is a parameter."""
    known = {name for group in NODES.values() for name in declarations(group)}
    groups = {name.partition('.')[0] for name in known if '.' in name}
    for path in DOCS.rglob('*.md'):
        for code in _code(path.read_text(encoding='utf-8')):
            name = re.sub(rf'^(?:{"|".join(NODES)}|/\*\*)\.', '', code)
            if re.fullmatch(rf'(?:{"|".join(groups)})\.\w+', name):
                assert name in known, f'{path}: {code}'


def test_the_tables_of_metrics_are_present_and_have_what_files_have():
    page = _page('metrics')
    for _, made in metric_tables.parts():
        assert made in page, 'make pages writes it again'
    torque = WheelTorque(0.0, 0.0)
    run = MeasuredRun('completed', 1.0, Pose(0.0, 0.0, 0.0), torque, Totals(), indices=PerformanceIndices())
    assert list(summary(run)) == [metric.name for metric in (*RUN_METRICS, *INDEX_METRICS)]
    assert list(metric_labels()) == list(METRICS)


def test_every_metric_is_defined():
    page = _code(_page('metrics'))
    torque = WheelTorque(0.0, 0.0)
    assert set(summary(MeasuredRun('completed', 0.0, Pose(0.0, 0.0, 0.0), torque, Totals()))) <= set(page)
    assert set(INDICES) <= set(page)
    names = ('rms_position_error', 'max_position_error', 'late_max_position_error', 'rms_heading_error',
             'peak_wheel_torque', 'energy', 'objective')
    judged = [Judged(k > 5, dict.fromkeys(names, 0.0)) for k in range(40)]
    study = summarise_runs(judged)
    assert {*study, *study['metrics'], *study['metrics']['energy'], *Generation._fields} <= set(page)
    failures = failure_values([Scenario('circle', 1.0 + (k > 5)) for k in range(40)], judged)
    assert {*failures, *failures['split'], *failures['ranges'], *failures['scenarios'][0]} <= set(page)
    comparison, = comparison_values({'one': judged, 'other': judged})
    assert {*comparison, *comparison['metrics'][0]} <= set(page)


def test_every_column_is_defined():
    table = _page('metrics').partition('## The table of a run')[2]
    defined = [code for line in table.splitlines() if line.startswith('| `')
               for code in _code(line.split('|')[1])]
    assert defined == list(CSV_COLUMNS)


def _options(text):
    return set(re.findall(r'(?<![\w-])--[a-z][a-z-]+', text))


def test_the_options_are_those_of_the_commands():
    code = (
        'import importlib, os\n'
        'os.environ["COLUMNS"] = "200"\n'
        f'for name in {COMMANDS!r}:\n'
        '    print("##", name)\n'
        '    try:\n'
        '        importlib.import_module("mobile_robot_control.cli." + name).main(["--help"])\n'
        '    except SystemExit:\n'
        '        pass\n'
    )
    printed = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, timeout=120,
                             check=True).stdout
    page = _page('commands')
    shared = _options(page.partition('## What all commands share')[2].partition('\n## ')[0])
    for section in printed.split('## ')[1:]:
        command, _, text = section.partition('\n')
        described = page.partition(f'\n## {command}\n')[2].partition('\n## ')[0]
        assert _options(text) == shared | {option for line in described.splitlines() if line.startswith('|')
                                           for option in _options(line)}, command


def test_decisions_are_numbered_and_dated():
    found = re.findall(r'^## (\d+)\. .+\n\n(\d{4}-\d\d-\d\d)\n\n', _page('decisions'), re.MULTILINE)
    assert [int(number) for number, _ in found] == list(range(1, len(found) + 1))
    assert len(found) == len(re.findall('^## ', _page('decisions'), re.MULTILINE))
    dates = [date for _, date in found]
    assert dates == sorted(dates)


def test_terms_of_the_glossary_stand_once():
    rows = re.findall(r'^\| ([^|]+) \|[^|]*\| (.+) \|$', _page('glossary').partition('\n## ')[0], re.MULTILINE)[1:]
    terms = [term for row, _ in rows for term in row.split(', ')]
    assert len(terms) == len(set(terms)) > 50


@pytest.mark.soak
def test_the_site_renders_without_a_warning(tmp_path):
    pytest.importorskip('furo', reason='the extra docs is not installed; make docs installs it')
    done = subprocess.run([sys.executable, '-m', 'sphinx', '-W', '--keep-going', '-q', '-b', 'html', '-d',
                           tmp_path / 'doctrees', DOCS, tmp_path / 'site'], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert 'step' in (tmp_path / 'site' / 'api' / 'laws.html').read_text(encoding='utf-8')
