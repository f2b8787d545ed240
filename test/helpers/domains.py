"""ROS domains that tests on one machine do not share."""

import contextlib
import itertools
import os
import socket
from pathlib import Path

# the ports of the domains between are those that Linux gives to any socket
DOMAINS = [*range(1, 102), *range(215, 231)]
_numbers = itertools.count(os.getpid() * 37)
_PORTS = 250
"""UDP ports of a domain, of which nodes take the lowest that are free; its last one is its lock here."""


@contextlib.contextmanager
def own_domain():
    """
    Yield the environment variables of a ROS domain in which no node is and that no other test has.

    Nodes that somebody left behind would be found, and so would those of tests in another container on the same
    network, which has another /tmp: the domain's ports decide.
    """
    for number in itertools.islice(_numbers, len(DOMAINS)):
        name = DOMAINS[number % len(DOMAINS)]
        first = 7400 + _PORTS * name
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as lock:
            try:
                lock.bind(('127.0.0.1', first + _PORTS - 1))
            except OSError:
                continue
            if any(first <= port < first + _PORTS - 1 for port in _bound()):
                continue
            yield {'ROS_DOMAIN_ID': str(name), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
        return
    raise RuntimeError('nodes are in every ROS domain; end them')


def _bound():
    """Return the UDP ports that sockets on this network have."""
    return {int(line.split()[1].rpartition(':')[2], 16) for table in Path('/proc/net').glob('udp*')
            for line in table.read_text(encoding='ascii').splitlines()[1:]}
