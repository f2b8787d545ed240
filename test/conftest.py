"""Shared by all tests: hypothesis draws the same examples in every run, each test over DDS has its own ROS domain."""

import gc
import os
import re
import signal
from pathlib import Path

import pytest
from helpers.browser import CHROMIUM, DRIVER, Browser, refuse_to_start
from helpers.domains import own_domain
from hypothesis import settings
from hypothesis.internal.conjecture import providers

# hypothesis also draws constants of the package's modules that are imported so far: those that other tests of a worker
# needed
providers._get_local_constants = lambda: providers._local_constants
settings.register_profile('seeded', derandomize=True, deadline=None, database=None)
settings.load_profile('seeded')

# no tests: one needs what `make mutants` alone installs, and others import for a second or share a name
collect_ignore_glob = ['mutants.py', 'bench/bench_*.py', 'helpers/ros_from_apt/*.py', '*/conftest.py']

# no number: a test that starts a node without the fixture `domain` fails, rather than join a domain of this machine
os.environ['ROS_DOMAIN_ID'] = 'see test/conftest.py: the fixture domain'

# under nohup, too, what the tests start takes a signal of a closed terminal
signal.signal(signal.SIGHUP, signal.SIG_DFL)

# beside other tests, threads of OpenBLAS wait for each other: an identification takes twice the CPU time
os.environ['OPENBLAS_NUM_THREADS'] = '1'

TOGETHER = ('test/closed_loop/', 'test/unit/benchmarking/', 'test/unit/conformance/', 'test/unit/search/',
            'test/unit/studying/', 'test/ros/dashboard/')
"""Folders whose tests compile rollouts, which one process does once, or share a dashboard."""


def scope_of(nodeid):
    """Return what goes to one worker: a folder of TOGETHER, a file, or one test where processes are waited for."""
    file = nodeid.partition('::')[0]
    together = [folder for folder in TOGETHER if file.startswith(folder)]
    if together:
        return together[0]
    return nodeid if file.startswith(('test/ros/', 'test/hostile/', 'test/examples/')) else file


# without xdist pytest does not know it
@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Divide tests among the workers by `scope_of`."""
    from xdist.scheduler import LoadScopeScheduling

    scheduler = LoadScopeScheduling(config, log)
    scheduler._split_scope = scope_of
    return scheduler


def pytest_collection_modifyitems(items):
    """Mark tests over DDS, which wait more than they compute, and mix them among the others; begin with long ones."""
    scopes = {True: {}, False: {}}
    for item in items:
        over_dds = not {'domain', 'live'}.isdisjoint(item.fixturenames)
        if over_dds:
            item.add_marker('dds')
        scopes[over_dds].setdefault(scope_of(item.nodeid), len(scopes[over_dds]))
    share = {scope: place / len(found) for found in scopes.values() for scope, place in found.items()}
    items.sort(key=lambda item: (
        not (scope_of(item.nodeid).endswith('/') or item.get_closest_marker('long')), share[scope_of(item.nodeid)]))


def pytest_collection_finish():
    """Leave what is loaded by now out of garbage collection, which took a seventh of the CPU time."""
    gc.freeze()
    gc.set_threshold(20000, 20, 20)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Keep what the browser shows when a test of a page fails."""
    report = yield
    if report.failed and call.when == 'call' and 'browser' in item.funcargs:
        name = re.sub(r'\W+', '_', item.name)
        path = Path('runs', 'failed_pages', f'{name}.png').absolute()
        path.parent.mkdir(parents=True, exist_ok=True)
        item.funcargs['browser'].driver.save_screenshot(str(path))
        report.sections.append(('the page', f'screenshot: {path}'))
    return report


def pytest_runtest_setup(item):
    """Without a browser, skip the tests of pages: here, so that their summary is one line."""
    if 'browser' in item.fixturenames and (CHROMIUM is None or DRIVER is None):
        refuse_to_start('no Chromium with its driver here; install chromium and chromium-driver')


@pytest.fixture
def domain(monkeypatch, tmp_path_factory):
    """A ROS domain of its own, for this process and its children, with the Fast DDS settings of an experiment."""
    from mobile_robot_control.experiment.node_processes import PROFILES_VARIABLES, use_fastdds_profiles

    with own_domain() as variables:
        for name, value in variables.items():
            monkeypatch.setenv(name, value)
        for name in PROFILES_VARIABLES:
            monkeypatch.delenv(name, raising=False)
        monkeypatch.setenv('ROS_HOME', str(tmp_path_factory.mktemp('ros_home')))
        use_fastdds_profiles(tmp_path_factory.mktemp('fastdds'))
        for name in {*PROFILES_VARIABLES} & os.environ.keys():  # for this test alone
            monkeypatch.setenv(name, os.environ.pop(name))
        yield


@pytest.fixture
def robot(domain, tmp_path):
    """One robot, whose nodes the test starts."""
    from helpers.harness import Robots

    robots = Robots(tmp_path)
    yield robots
    robots.close()


@pytest.fixture
def bare_domain(domain, monkeypatch):
    """A ROS domain on this machine, in which nodes and commands start without any Fast DDS settings."""
    from mobile_robot_control.experiment.node_processes import PROFILES_VARIABLES

    for name in PROFILES_VARIABLES:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')


@pytest.fixture(scope='session')
def browser(tmp_path_factory):
    """A headless Chromium, one for all tests of a process."""
    with Browser(tmp_path_factory.mktemp('profile')) as started:
        yield started


@pytest.fixture
def registered():
    """Registers laws and curves for one test; what comes from files is forgotten after it, too."""
    from mobile_robot_control.parameters.plugins import REGISTRIES, register

    before = {kind: set(registry) for kind, registry in REGISTRIES.items()}
    yield register
    for kind, registry in REGISTRIES.items():
        for name in set(registry) - before[kind]:
            registry.remove(name)


@pytest.fixture(autouse=True)
def signal_handlers():
    """Restore the handlers of signals that the parser of `experiment` installs for the rest of a process."""
    before = {number: signal.getsignal(number) for number in (
        signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def quick(monkeypatch):
    """A report draws one figure of each kind."""
    from mobile_robot_control.report import report_writing

    for figures in ('RUN_FIGURES', 'TIMING_FIGURES'):
        monkeypatch.setattr(report_writing, figures, getattr(report_writing, figures)[:1])


@pytest.fixture
def plain(monkeypatch, quick):
    """A search or a study compiles and draws nothing."""
    from mobile_robot_control.figures import drawing
    from mobile_robot_control.loop import batch

    monkeypatch.setattr(batch, 'COMPILES', False)
    monkeypatch.setattr(drawing, 'draw_and_save', lambda *_: '')
