"""The live page with no browser open: what it takes from the nodes that it is attached to, and what it needs itself."""

import signal
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from bench import bench_lockstep, bench_wall_clock
from bench.graph import CONFIG, Graph, alternate, cpu_seconds, graphs, proportional_megabytes
from bench.odometer import Odometer
from bench.progress import show
from bench.row import Row, at_least, at_most, median_ratio
from mobile_robot_control.settings.nodes import NODES

WINDOWS, SECONDS = 8, 2.0
MEGABYTES, SHARE = 150.0, 0.25
"""[MB] and share of a core that the page may need."""


def watch(graph: Graph, folder: Path) -> None:
    """Attach a page to a graph."""
    graph.start('dashboard', 'mobile_robot_control.dashboard.command', '--attach', '--port', '0', '--output', folder)


def speeds(folder: Path, windows: int = WINDOWS) -> tuple[list[float], list[float]]:
    """Measure simulated seconds in a second, with a page and without, in turn."""
    found: dict[Graph, list[float]] = {}
    with graphs(2) as both:
        for graph in both:
            for name in NODES:
                graph.start(name, 'mobile_robot_control.ros.start.executables', name, '--ros-args',
                            '--params-file', CONFIG / 'backstepping.yaml', '-p', 'real_time_factor:=0.0')
        watch(both[0], folder)
        odometers = {graph: Odometer(graph) for graph in both}
        try:
            for graph, odometer in odometers.items():
                found[graph] = []
                odometer.reach(0)
            time.sleep(5.0)  # the page discovers the nodes
            for window, graph in alternate(both, windows, bench_lockstep.WARM_UP):
                found[graph].append(odometers[graph].speed(1.0))
                show(f'dashboard, lockstep, window {window + 1} of {windows}: {found[graph][-1]:.2f}')
        finally:
            for odometer in odometers.values():
                odometer.close()
    watched, alone = found.values()
    return watched, alone


class Measured:
    """Ages [s] with a page and without, window by window, and what the page needs: [MB], shares of a core."""

    def __init__(self) -> None:
        self.ages: dict[tuple[str, str], tuple[list[list[float]], list[list[float]]]] = defaultdict(lambda: ([], []))
        self.megabytes, self.shares = 0.0, list[float]()


def on_the_wall_clock(folder: Path, windows: int = WINDOWS, seconds: float = SECONDS) -> Measured:
    """Measure on the wall clock, with a page and without, in turn."""
    measured = Measured()
    with graphs(2) as both:
        for graph in both:
            bench_wall_clock.start_ours(graph, folder)
        watch(both[0], folder / 'page')
        time.sleep(8.0)  # discovery, and the robot under way
        page = both[0].pids['dashboard']
        for window, graph in alternate(both, windows, bench_wall_clock.WARM_UP):
            show(f'dashboard, wall clock, window {window + 1} of {windows}')
            graph.signal_nodes(signal.SIGUSR1, NODES)
            began, before = time.monotonic(), cpu_seconds(page)
            time.sleep(seconds)
            if graph is both[0]:
                measured.shares.append((cpu_seconds(page) - before) / (time.monotonic() - began))
            graph.signal_nodes(signal.SIGUSR2, NODES)
            for key, ages in bench_wall_clock.read_ages(folder, graph, window).items():
                measured.ages[key][both.index(graph)].append(ages)
        measured.megabytes = proportional_megabytes(page)
    return measured


def rows() -> Iterator[Row]:
    """Compare speed and ages with those without a page, memory and CPU time with what is allowed."""
    with tempfile.TemporaryDirectory() as place:
        watched, alone = speeds(Path(place))
        measured = on_the_wall_clock(Path(place))
    yield at_least('lockstep speed with the live page', median_ratio(watched, alone), 0.9,
                   f'{statistics.median(watched):.2f} to {statistics.median(alone):.2f} s simulated in 1 s')
    yield at_most('memory of the live page to 150 MB', measured.megabytes / MEGABYTES, 1.0,
                  f'{measured.megabytes:.0f} MB (PSS)')
    share = statistics.median(measured.shares)
    yield at_most('CPU of the live page to a quarter of a core', share / SHARE, 1.0, f'{100 * share:.1f} % of a core')
    for (name, topic), pair in measured.ages.items():
        for word, statistic in bench_wall_clock.STATISTICS.items():
            with_page, without = ([statistic(ages) for ages in windows] for windows in pair)
            yield at_most(f'age of {topic} in {name} with the live page, {word}', median_ratio(with_page, without),
                          1.3, f'{1e3 * statistics.median(with_page):.2f} to {1e3 * statistics.median(without):.2f} ms')
