"""The pages in docs/ agree with the code: parameters, topics, metrics, columns, options, numbers of decisions."""

import fnmatch
import re
import subprocess
import sys
from pathlib import Path

import metric_tables
import pytest
import topic_tables
from notebook_page import markdown_of
from parameter_table import insert_parameters, tables
from robots_table import insert_robots

from mobile_robot_control.analysis.modelled import EFFECTS, effect_of
from mobile_robot_control.loop.indices import MeasuredRun, PerformanceIndices, Totals
from mobile_robot_control.loop.metric_table import INDEX_METRICS, INDICES, RUN_METRICS
from mobile_robot_control.loop.monte_carlo import METRICS, Judged, metric_labels, summarise_runs
from mobile_robot_control.loop.scenarios import Scenario
from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.quantities import Pose, WheelTorque
from mobile_robot_control.ros.shared.diagnostics import SUBSCRIBERS_KEY
from mobile_robot_control.runs.csv_table import CSV_COLUMNS
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.search.search import Generation
from mobile_robot_control.settings.nodes import NODES, parameter_names
from mobile_robot_control.studying.comparison import comparison_values
from mobile_robot_control.studying.failures import failure_values

DOCS = Path(__file__).parents[2] / 'docs'
PAGES = {path.stem: path.read_text(encoding='utf-8') for path in (DOCS / 'nodes').glob('*.md')}


def _page(name):
    return (DOCS / f'{name}.md').read_text(encoding='utf-8')


def _code(text):
    """All that stands between backticks."""
    return re.findall(r'`([^`]+)`', re.sub(r'^```.*?^```', '', text, flags=re.DOTALL | re.MULTILINE))


def test_there_is_a_page_for_each_node_with_the_table_of_its_parameters():
    assert set(PAGES) == set(NODES)
    for node, page in PAGES.items():
        assert insert_parameters(page) == page
        assert tables(node) in page


def test_the_table_of_shared_parameters_is_present_and_links_to_that_of_each_node():
    page = _page('parameters')
    assert insert_parameters(page) == page
    assert tables() in page
    assert all(f'(nodes/{node}.md#parameters)' in page for node in NODES)


def test_every_gain_and_constant_of_the_robot_says_what_a_larger_value_does():
    # places, pauses and positions in time: a larger value does nothing to the robot
    others = {'hold_at', 'initial_pose', 'center', 'rotation'}
    for group in NODES.values():
        for name, declared in declarations(group).items():
            text = declared.field.description
            assert len(text) > 5
            assert not text.endswith('.')
            if (declared.field.live or name.startswith('robot.')) and declared.kind in (float, tuple):
                assert name in others or 'larger' in text, name


def test_every_imperfection_of_the_plant_is_an_effect_that_margins_and_promises_name():
    # but what only says when, or belongs to the node
    groups = ('base', 'delay', 'disturbance', 'encoders', 'friction', 'motor', 'noise', 'odometry')
    names = {f'{node}.{name}' for node, names in parameter_names().items() for name in names}
    imperfect = {name for name in names if name.startswith(tuple(f'plant.{group}.' for group in groups))}
    assert {name for name in imperfect if effect_of(name) is None} == {
        'plant.noise.seed', 'plant.disturbance.time', 'plant.base.command_timeout'}
    assert all(fnmatch.filter(names, pattern) for effect in EFFECTS for pattern in effect.parameters)


def test_the_tables_of_all_robots_are_present():
    page = _page('robots')
    assert insert_robots(page) == page
    assert {file.stem for file in (DOCS.parent / 'config' / 'robots').iterdir()} == set(
        re.findall('^## (.+)$', page.partition('<!-- robots: generated -->')[2], re.MULTILINE))


def test_its_topics_are_those_of_the_node(domain):
    code = (
        'import rclpy\n'
        'from mobile_robot_control.ros.start.loaded import load\n'
        'from mobile_robot_control.settings.nodes import NODES\n'
        'rclpy.init()\n'
        'for name in NODES:\n'
        '    node = load(name)()\n'
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


def test_the_page_of_topics_names_the_key_of_the_diagnostics():
    assert f'{SUBSCRIBERS_KEY}TOPIC' in _code(_page('topics'))


def test_the_tables_of_topics_on_the_pages_are_those_of_the_loop():
    for file, (part, made) in topic_tables.parts().items():
        assert part.found((DOCS.parent / file).read_text(encoding='utf-8')) == made, 'make pages writes it again'


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
    run = MeasuredRun('completed', 1.0, Pose(0.0, 0.0, 0.0), WheelTorque(0.0, 0.0), Totals(),
                      indices=PerformanceIndices())
    assert list(summary(run)) == [metric.name for metric in (*RUN_METRICS, *INDEX_METRICS)]
    assert list(metric_labels()) == list(METRICS)
    defined = [code for line in page.partition('## The table of a run')[2].splitlines() if line.startswith('| `')
               for code in _code(line.split('|')[1])]
    assert defined == list(CSV_COLUMNS)


def test_every_metric_is_defined():
    page = set(_code(_page('metrics')))
    names = ('rms_position_error', 'max_position_error', 'late_max_position_error', 'rms_heading_error',
             'peak_wheel_torque', 'energy', 'objective')
    judged = [Judged(k > 5, dict.fromkeys(names, 0.0)) for k in range(40)]
    study = summarise_runs(judged)
    failures = failure_values([Scenario('circle', 1.0 + (k > 5)) for k in range(40)], judged)
    comparison, = comparison_values({'one': judged, 'other': judged})
    for some in (INDICES, study, study['metrics'], study['metrics']['energy'], Generation._fields, failures,
                 failures['split'], failures['ranges'], failures['scenarios'][0], comparison, comparison['metrics'][0]):
        assert set(some) <= page


def test_the_page_of_commands_is_their_help(tmp_path):
    """In a process of its own: a parser takes the signals over."""
    page = tmp_path / 'commands.md'
    emptied = re.sub(r'(<!-- (\w+): generated -->).*?(<!-- end of \2 -->)', r'\1\n\3', _page('commands'),
                     flags=re.DOTALL)
    assert emptied.count(': generated -->\n<!-- end of ') == 3
    page.write_text(emptied, encoding='utf-8')
    subprocess.run([sys.executable, DOCS.parent / 'tools' / 'command_pages.py', page], timeout=120, check=True)
    assert page.read_text(encoding='utf-8') == _page('commands'), 'make pages writes it again'


def test_decisions_are_numbered_and_dated():
    """The numbers of those that no page needs any more are left out."""
    found = re.findall(r'^## (\d+)\. .+\n\n(\d{4}-\d\d-\d\d)\n\n', _page('decisions'), re.MULTILINE)
    numbers = [int(number) for number, _ in found]
    assert numbers == sorted(set(numbers))
    assert len(found) == len(re.findall('^## ', _page('decisions'), re.MULTILINE))
    dates = [date for _, date in found]
    assert dates == sorted(dates)


def test_the_notebook_is_a_page_of_the_site():
    page = markdown_of(DOCS.parent / 'examples' / 'tutorial' / 'trajectory_tracking.ipynb')
    assert '\n## Exercises\n' in page
    assert not re.search('^# ', re.sub('^````.*?^````', '', page, flags=re.DOTALL | re.MULTILINE), re.MULTILINE)
    assert 'data:image/png;base64,' in page
    for target in re.findall(r'\]\(((?!data:)[^)#]+)', page):
        assert (DOCS / target).exists(), target


def _render(folder):
    pytest.importorskip('furo', reason='the extra docs is not installed; make docs installs it')
    done = subprocess.run([sys.executable, '-m', 'sphinx', '-W', '--keep-going', '-q', '-b', 'html', '-d',
                           folder / 'doctrees', DOCS, folder / 'site'], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / 'site'


@pytest.mark.soak
def test_the_site_renders_without_a_warning_and_typesets_formulas(tmp_path):
    site = _render(tmp_path)
    assert 'step' in (site / 'api' / 'laws.html').read_text(encoding='utf-8')
    for page in ('how_it_works', 'tutorial'):
        assert '<math' in (site / f'{page}.html').read_text(encoding='utf-8')


@pytest.mark.soak
def test_the_search_of_the_site_works_from_a_disk(browser, tmp_path):
    from selenium.webdriver.support.wait import WebDriverWait

    site = _render(tmp_path)
    browser.show(site / 'index.html', 1200)
    browser.driver.find_element('css selector', 'input[name=q]').send_keys('lemniscate\n')
    WebDriverWait(browser.driver, 60).until(
        lambda driver: len(driver.find_elements('css selector', 'ul.search a')) > 5)
    assert not browser.errors()


@pytest.mark.parametrize('page', ['README.md', 'docs/lockstep.md', 'docs/how_it_works.md'])
def test_runs_are_promised_to_repeat_on_every_machine(page):
    sentences = re.split(r'[.:] ', ' '.join((DOCS.parent / page).read_text(encoding='utf-8').split()))
    promised = [text for text in sentences if re.search(r'(runs|reruns)\b.*(last bit|are equal)', text)]
    assert promised
    assert all(re.search('(every|any) machine', text) for text in promised)
