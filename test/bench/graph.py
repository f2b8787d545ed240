"""Nodes as processes in a ROS domain of their own, which can be suspended and resumed, and what they cost."""

import contextlib
import itertools
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from helpers.domains import own_domain

CONFIG = Path(__file__).parents[2] / 'config'
_GRACE = 5.0
"""[s] that processes have to end by themselves."""
_domains = contextlib.ExitStack()
"""Those of this run, for as long as its process lives."""


def new_domain() -> int:
    """Give a ROS domain that nothing else uses; this process may join it, too."""
    found = _domains.enter_context(own_domain())
    name = found.pop('ROS_DOMAIN_ID')
    os.environ.update(found)
    return int(name)


class Graph:
    """
    Processes, each with a node or several, in one domain.

    Parameters
    ----------
    domain : int
        ROS domain.

    """

    def __init__(self, domain: int) -> None:
        self.domain = domain
        path = os.pathsep.join(filter(None, [str(Path(__file__).parents[1]), os.environ.get('PYTHONPATH')]))
        self._environment = os.environ | {'ROS_DOMAIN_ID': str(domain), 'PYTHONPATH': path}
        # rclpy was compiled when it was installed; what a node imports of ours must not be compiled at every start
        self._environment.pop('PYTHONDONTWRITEBYTECODE', None)
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the graph)
        self._suspended = False

    @property
    def pids(self) -> dict[str, int]:
        """Process numbers by the names that they were started under."""
        return {name: process.pid for name, process in self._processes.items()}

    def start(self, name: str, module: str, *arguments: object) -> None:
        """Run a module of Python's; it ends with this process, when its standard input closes."""
        self._processes[name] = subprocess.Popen(
            [sys.executable, '-m', module, *map(str, arguments)], env=self._environment, stdin=subprocess.PIPE,
            stdout=self._output, stderr=self._output, start_new_session=True,
        )

    def signal(self, number: int) -> None:
        """Send a signal to all processes."""
        for process in self._processes.values():
            process.send_signal(number)

    def signal_nodes(self, number: int, names: Iterable[str]) -> None:
        """Send a signal to some processes."""
        for name in names:
            self._processes[name].send_signal(number)

    def suspend(self) -> None:
        """Suspend all by SIGSTOP."""
        self._suspended = True
        self.signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Resume all."""
        if self._suspended:
            self.signal(signal.SIGCONT)
        self._suspended = False

    def check(self) -> None:
        """Raise if a process has ended, with what was printed."""
        ended = {name: process.returncode for name, process in self._processes.items() if process.poll() is not None}
        if ended:
            self._output.seek(0)
            raise RuntimeError(f'{ended} ended early: {self._output.read().decode(errors="replace")[-2000:]}')

    def close(self) -> None:
        """End all processes."""
        self.signal(signal.SIGCONT)
        self.signal(signal.SIGTERM)
        deadline = time.monotonic() + _GRACE
        for process in self._processes.values():
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            if process.stdin is not None:
                process.stdin.close()
        self._processes.clear()
        self._output.close()


@contextlib.contextmanager
def graphs(number: int) -> Iterator[list[Graph]]:
    """Give that many graphs, each in a domain of its own, and end their processes."""
    made = [Graph(new_domain()) for _ in range(number)]
    try:
        yield made
    finally:
        for graph in made:
            graph.close()


def alternate(measured: Sequence[Graph], windows: int, warm_up: float) -> Iterator[tuple[int, Graph]]:
    """
    Let one graph at a time run, in turn, all others suspended.

    Yields the number of the round and the graph, `warm_up` [s] after it was resumed.
    """
    for graph in measured:
        graph.suspend()
    for window, graph in itertools.product(range(windows), measured):
        graph.resume()
        time.sleep(warm_up)
        yield window, graph
        graph.check()
        graph.suspend()


def cpu_seconds(pid: int) -> float:
    """Give the CPU time of all threads that a process has [s]."""
    tasks = Path(f'/proc/{pid}/task')
    return sum(int((task / 'schedstat').read_text().split()[0]) for task in tasks.iterdir()) / 1e9


def proportional_megabytes(pid: int) -> float:
    """Give a process's share of memory [MB]: what it shares with others counts in equal parts (PSS)."""
    for line in Path(f'/proc/{pid}/smaps_rollup').read_text().splitlines():
        if line.startswith('Pss:'):
            return int(line.split()[1]) * 1024 / 1e6
    raise RuntimeError(f'/proc/{pid}/smaps_rollup has no Pss')
