"""A robot for each test over DDS."""

import pytest
from harness import Robot


@pytest.fixture
def robot(domain, tmp_path):
    """A robot whose nodes the test starts."""
    made = Robot(tmp_path)
    yield made
    made.close()
