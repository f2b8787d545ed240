"""What all tests share: hypothesis draws the same examples in every run; each test has a ROS domain of its own."""

import itertools
import os

import pytest
from hypothesis import settings

settings.register_profile('seeded', derandomize=True, deadline=None, database=None)
settings.load_profile('seeded')

_domains = itertools.count(os.getpid() * 37)


@pytest.fixture
def domain(monkeypatch):
    """A ROS domain that no other test uses, for this process and its children."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(next(_domains) % 230 + 1))
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
