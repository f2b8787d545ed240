"""How long paths take to be planned: against toppra, and against what a user waits for; and a node with a path."""

import math
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import toppra
from helpers.toppra_oracle import Oracle

from bench.bench_start import times
from bench.progress import show
from bench.row import Row, at_most
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.reference.motion import PathMotion, plan
from mobile_robot_control.reference.path_fit import fitted
from mobile_robot_control.reference.path_parameters import Drive, PathParameters, PathRequest, Timing
from mobile_robot_control.reference.path_shape import PathGrid, control_points, spans_of
from mobile_robot_control.reference.planned_path import plan_spans
from mobile_robot_control.reference.waypoints import checked_waypoints

ROBOT = Robot(viscous_friction=0.0)
TIMING = Timing(
    max_linear_velocity=0.6, max_linear_acceleration=0.5, max_angular_acceleration=4.0, max_wheel_torque=0.4)
LIMITS = Timing(max_linear_velocity=0.4, max_linear_acceleration=0.4, max_angular_velocity=1.2,
                max_angular_acceleration=2.5)
LONGEST = 0.4
"""[s] for 1,000 points."""
LATER = 0.3
"""[s] by which a node with a path may start later."""


def waves(count: int) -> list[tuple[float, float]]:
    """Return so many waypoints on a sine wave, ten of them a wavelength."""
    return [(0.1 * n, 0.3 * math.sin(0.2 * math.pi * n)) for n in range(count)]


def route(cell: float) -> list[tuple[float, float]]:
    """Return a planner's plan on a grid [m]."""
    return [(0.05 * n, cell * round(0.8 * math.sin(0.055 * n) / cell)) for n in range(104)]


def planned(points: list[tuple[float, float]], timing: Timing = TIMING) -> tuple[float, PathMotion]:
    """Plan a path of waypoints; return the seconds of CPU that it took, and the path."""
    plan.cache_clear()
    begun = time.process_time()
    waypoints = checked_waypoints([(str(n), point) for n, point in enumerate(points)], 'waves')
    path = plan(PathRequest(waypoints, PathParameters(), timing, Drive(ROBOT)))
    return time.process_time() - begun, path


def toppra_seconds(grid: PathGrid) -> float:
    """Return the seconds of CPU that toppra takes for a grid."""
    begun = time.process_time()
    Oracle(toppra, grid, TIMING, ROBOT).duration()
    return time.process_time() - begun


def rows() -> Iterator[Row]:
    """Compare the planning of paths."""
    toppra.setup_logging('ERROR')
    ours, theirs = [], []
    for _ in range(5):
        spans = spans_of([point for point, _ in control_points(waves(50), False, 0.05)], False)
        begun = time.process_time()
        path = plan_spans(spans, TIMING, Drive(ROBOT))
        ours.append(time.process_time() - begun)
        theirs.append(toppra_seconds(path.grid))
        show(f'paths: {len(path.limit)} points in {ours[-1]:.3f} s, by toppra in {theirs[-1]:.3f} s')
    typical, other, points = statistics.median(ours), statistics.median(theirs), len(path.limit)
    yield at_most(f'plan of {points} points / toppra', typical / other, 10.0, f'{typical:.3f} to {other:.3f} s of CPU')
    yield at_most(f'plan of {points} points / {LONGEST} s', typical / LONGEST, 1.0, f'{typical:.3f} s of CPU')
    clean, grid = [], []
    for _ in range(9):
        spans = spans_of([point for point, _ in fitted(route(0.001), False, 0.05)], False)
        begun = time.process_time()
        plan_spans(spans, LIMITS, Drive(ROBOT))
        clean.append(time.process_time() - begun)
        grid.append(planned(route(0.05), LIMITS)[0])
    whole, timed = statistics.median(grid), statistics.median(clean)
    yield at_most('plan of a grid: intake, fit, timing / timing', whole / timed, 2.5,
                  f'{whole:.4f} to {timed:.4f} s of CPU')
    few, many = planned(waves(500)), planned(waves(5000))
    sizes = [len(path.limit) for _, path in (few, many)]
    growth = (many[0] / few[0]) / (sizes[1] / sizes[0])
    yield at_most(f'time a point of {sizes[1]} points / of {sizes[0]}', growth, 1.5, f'{few[0]:.2f} to {many[0]:.2f} s')
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / 'waves.csv'
        file.write_text(''.join(f'{x},{y}\n' for x, y in waves(50)))
        timing = [word for name, value in TIMING._asdict().items() for word in ('-p', f'timing.{name}:={value}')]
        found = times(3, {'reference_cart': [], 'reference_cart, a path': [
            '-p', 'reference_cart:curve:=path', '-p', f'path.file:={file}', *timing]})
    plain, with_path = (statistics.median(found[name]) for name in ('reference_cart', 'reference_cart, a path'))
    yield at_most(f'later start with a path / {LATER} s', (with_path - plain) / LATER, 1.0,
                  f'{with_path:.2f} to {plain:.2f} s to the first message')
