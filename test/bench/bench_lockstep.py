"""Lockstep at everyday rates: how fast the four nodes go, against a bare exchange and against the wall clock."""

import statistics
from collections.abc import Iterator

from bench.bare_lockstep import PERIOD
from bench.graph import CONFIG, Graph, alternate, graphs
from bench.odometer import Odometer
from bench.progress import show
from bench.row import Row, at_least, median_ratio
from mobile_robot_control.settings.nodes import NODES

WINDOWS, SECONDS, WARM_UP = 20, 0.6, 0.25


def start(ours: Graph, bare: Graph) -> None:
    """Start both graphs, each node in a process of its own."""
    for name in NODES:
        ours.start(name, 'mobile_robot_control.ros.start.executables', name, '--ros-args',
                   '--params-file', CONFIG / 'backstepping.yaml', '-p', 'real_time_factor:=0.0')
        bare.start(name, 'bench.bare_lockstep', name)


def cycles(windows: int = WINDOWS, seconds: float = SECONDS) -> tuple[list[float], list[float]]:
    """Count cycles per second of our nodes and of bare ones, in turn."""
    rates: dict[Graph, list[float]] = {}
    with graphs(2) as both:
        start(*both)
        odometers = {graph: Odometer(graph) for graph in both}
        try:
            for graph, odometer in odometers.items():
                rates[graph] = []
                odometer.reach(0)
            for window, graph in alternate(both, windows, WARM_UP):
                rates[graph].append(odometers[graph].speed(seconds) * 1e9 / PERIOD)
                show(f'lockstep, window {window + 1} of {windows}: {rates[graph][-1]:.0f} cycles/s')
        finally:
            for odometer in odometers.values():
                odometer.close()
    ours, bare = rates.values()
    return ours, bare


def rows() -> Iterator[Row]:
    """Compare cycles per second."""
    ours, bare = cycles()
    yield at_least('lockstep cycles/s to a bare exchange', median_ratio(ours, bare), 0.8,
                   f'{statistics.median(ours):.0f} to {statistics.median(bare):.0f} cycles/s, medians of {len(ours)}')
    speed = statistics.median(ours) * PERIOD / 1e9
    yield at_least('lockstep speed to real time', speed, 2.0, f'{speed:.2f} s simulated in 1 s, median of {len(ours)}')
