"""Memory of each node, against an empty rclpy node's in the same domain at the same moment."""

import contextlib
from collections.abc import Iterator

from bench.graph import CONFIG, graphs, proportional_megabytes
from bench.odometer import Odometer
from bench.progress import show
from bench.row import Row, at_most
from mobile_robot_control.settings.nodes import NODES

MORE = 10.0
"""[MB] that a node may need beyond an empty one."""


def megabytes(simulated: float = 4.0) -> dict[str, float]:
    """Give the memory of an empty node and of ours, after a while of a run at everyday rates."""
    with graphs(1) as (graph,):
        graph.start('empty', 'bench.empty_node')
        for name in NODES:
            graph.start(name, 'mobile_robot_control.ros.start.executables', name, '--ros-args',
                        '--params-file', CONFIG / 'backstepping.yaml')
        show('memory, a run under way')
        with contextlib.closing(Odometer(graph)) as odometer:
            odometer.reach(round(simulated * 1e9))
        return {name: proportional_megabytes(pid) for name, pid in graph.pids.items()}


def rows() -> Iterator[Row]:
    """Compare shares of memory."""
    found = megabytes()
    empty = found.pop('empty')
    for name, ours in found.items():
        yield at_most(f'memory of {name}', ours / empty, (empty + MORE) / empty,
                      f'{ours:.1f} to {empty:.1f} MB, {ours - empty:+.1f} of {MORE:+.1f} MB allowed (PSS)')
