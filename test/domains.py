"""ROS domains that tests on one machine do not share."""

import contextlib
import fcntl
import itertools
import os
import tempfile
from pathlib import Path

# the ports of the domains between are those that Linux gives to any socket
DOMAINS = [*range(1, 102), *range(215, 231)]
_numbers = itertools.count(os.getpid() * 37)


@contextlib.contextmanager
def own_domain():
    """Yield the environment variables of a ROS domain that no other test on this machine uses."""
    for number in _numbers:
        name = DOMAINS[number % len(DOMAINS)]
        with (Path(tempfile.gettempdir()) / f'ros_domain_{name}.lock').open('w') as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            yield {'ROS_DOMAIN_ID': str(name), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
        return
