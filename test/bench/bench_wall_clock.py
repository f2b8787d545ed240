"""On the wall clock at 200 and 50 Hz: CPU time and input ages, against nodes that only pass messages on."""

import json
import signal
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from bench.bare_wall_clock import TOPICS
from bench.graph import CONFIG, Graph, alternate, cpu_seconds, graphs
from bench.progress import show
from bench.row import Row, at_most, median_ratio

WINDOWS, SECONDS, WARM_UP = 8, 2.6, 0.8

PERIODS = {'plant': 5_000_000, 'velocity_controller': 5_010_000, 'position_controller': 20_160_000,
           'reference_cart': 20_320_000}
"""
[ns]. Timers of equal period keep the phase that they happened to start with, and the ages with it. Periods that differ
a little go through all phases within a window: the ages of two runs can be compared.
"""
STATISTICS = {
    'median': statistics.median,
    '99 %': lambda ages: statistics.quantiles(ages, n=100)[98],
    'max': max,
}


def start_ours(graph: Graph, probed: Path) -> None:
    """Start our nodes with probes that write to a folder."""
    for name, period in PERIODS.items():
        graph.start(name, 'bench.probe', probed / f'{graph.domain}_{name}',
                    'mobile_robot_control.ros.start.executables', *_arguments(name, period))


def _arguments(name: str, period: int) -> tuple[object, ...]:
    """
    Give the arguments of one of our nodes that ticks with a period [ns].

    Without reference_horizon, whose points are a period of the cart apart: another node refuses them.
    """
    velocity = period if period < 10_000_000 else period // 4
    return (name, '--ros-args', '--params-file', CONFIG / 'wall_clock.yaml', '-p', f'velocity_rate:={1e9 / velocity!r}',
            '-p', f'position_rate:={1e9 / (4 * velocity)!r}', '-p', 'reference_horizon:=0', '-p',
            'feedforward.enabled:=false')


def start(ours: Graph, bare: Graph, probed: Path | None = None) -> None:
    """Start both graphs, each node in a process of its own, with probes that write to a folder or without."""
    for name, period in PERIODS.items():
        for graph, module, *arguments in (
            (ours, 'mobile_robot_control.ros.start.executables', *_arguments(name, period)),
            (bare, 'bench.bare_wall_clock', name, period),
        ):
            if probed is None:
                graph.start(name, module, *arguments)
            else:
                graph.start(name, 'bench.probe', probed / f'{graph.domain}_{name}', module, *arguments)


def _lines(path: Path) -> list[str]:
    """Read the whole lines that a probe has written."""
    return path.read_text().split('\n')[:-1] if path.exists() else []


def read_ages(folder: Path, graph: Graph, window: int) -> dict[tuple[str, str], list[float]]:
    """Read the ages that the probes noted in a window, by node and input."""
    deadline = time.monotonic() + 5.0
    found: dict[tuple[str, str], list[float]] = {}
    for name in TOPICS:
        while len(lines := _lines(folder / f'{graph.domain}_{name}')) <= window:
            graph.check()
            if time.monotonic() > deadline:
                raise TimeoutError(f'the probe of {name} has written nothing')
            time.sleep(0.01)
        if name != 'reference_cart':  # what it publishes does not depend on its input
            found.update({(name, topic): ages for topic, ages in json.loads(lines[window]).items()})
    return found


class Measured:
    """What was measured of our nodes and of those that pass on, window by window."""

    def __init__(self) -> None:
        self.cpu: dict[str, tuple[list[float], list[float]]] = defaultdict(lambda: ([], []))
        self.ages: dict[tuple[str, str], tuple[list[list[float]], list[list[float]]]] = defaultdict(lambda: ([], []))


def measure(windows: int = WINDOWS, seconds: float = SECONDS) -> Measured:
    """Measure CPU time without probes and ages with them, in turn."""
    measured = Measured()
    with graphs(4) as four, tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        start(*four[:2])
        start(*four[2:], folder)
        time.sleep(4.0)  # discovery, and the robot under way
        for window, graph in alternate(four, windows, WARM_UP):
            number = four.index(graph)
            show(f'wall clock, window {window + 1} of {windows}, {("CPU time", "ages")[number // 2]} '
                f'of {("ours", "bare nodes")[number % 2]}')
            if number < 2:
                _measure_cpu(measured, graph, number, seconds)
            else:
                graph.signal(signal.SIGUSR1)
                time.sleep(seconds)
                graph.signal(signal.SIGUSR2)
                for key, ages in read_ages(folder, graph, window).items():
                    measured.ages[key][number - 2].append(ages)
    return measured


def _measure_cpu(measured: Measured, graph: Graph, number: int, seconds: float) -> None:
    began = time.monotonic()
    before = {name: cpu_seconds(pid) for name, pid in graph.pids.items()}
    time.sleep(seconds)
    for name, pid in graph.pids.items():
        measured.cpu[name][number].append((cpu_seconds(pid) - before[name]) / (time.monotonic() - began))


def rows() -> Iterator[Row]:
    """Compare CPU times and ages."""
    measured = measure()
    for name, (ours, bare) in measured.cpu.items():
        yield at_most(
            f'CPU of {name}', median_ratio(ours, bare), 1.3,
            f'{100 * statistics.median(ours):.1f} to {100 * statistics.median(bare):.1f} % of a core',
        )
    for (name, topic), pair in measured.ages.items():
        for word, statistic in STATISTICS.items():
            ours, bare = ([statistic(ages) for ages in windows] for windows in pair)
            yield at_most(
                f'age of {topic} in {name}, {word}', median_ratio(ours, bare), 1.3,
                f'{1e3 * statistics.median(ours):.2f} to {1e3 * statistics.median(bare):.2f} ms',
            )
