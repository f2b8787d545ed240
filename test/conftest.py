"""Shared by all tests: hypothesis draws the same examples in every run, each test over DDS has its own ROS domain."""

import os

import pytest
from browser import CHROMIUM, DRIVER, Browser, refuse_to_start
from domains import own_domain
from hypothesis import settings

settings.register_profile('seeded', derandomize=True, deadline=None, database=None)
settings.load_profile('seeded')

# what only `make mutants` installs
collect_ignore = ['mutants.py']

# no number: a test that starts a node without the fixture `domain` fails, rather than join a domain of this machine
os.environ['ROS_DOMAIN_ID'] = 'see test/conftest.py: the fixture domain'


def pytest_collection_modifyitems(items):
    """Mark every test over DDS."""
    for item in items:
        if 'domain' in item.fixturenames:
            item.add_marker('dds')


def pytest_runtest_setup(item):
    """Without a browser, skip the tests of pages: here, so that their summary is one line."""
    if 'browser' in item.fixturenames and (CHROMIUM is None or DRIVER is None):
        refuse_to_start('no Chromium with its driver here; install chromium and chromium-driver')


@pytest.fixture
def domain(monkeypatch):
    """A ROS domain of its own, for this process and its children."""
    with own_domain() as variables:
        for name, value in variables.items():
            monkeypatch.setenv(name, value)
        yield


@pytest.fixture(scope='session')
def browser(tmp_path_factory):
    """A headless Chromium, one for all tests of a process."""
    with Browser(tmp_path_factory.mktemp('profile')) as started:
        yield started


@pytest.fixture
def registered():
    """Registers laws and curves for one test; what comes from files is forgotten after it, too."""
    from mobile_robot_control.plugins import REGISTRIES, register

    before = {kind: set(registry) for kind, registry in REGISTRIES.items()}
    yield register
    for kind, registry in REGISTRIES.items():
        for name in set(registry) - before[kind]:
            registry.remove(name)
