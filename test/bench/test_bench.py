"""The benchmarks: their arithmetic always, the nodes that they compare ours with in the long tests."""

import importlib
import json
import math
import os
import signal
import sys
import time
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from bench import __main__, bench_lockstep, bench_memory, bench_start, bench_wall_clock, probe
from bench.bare_messages import MESSAGES
from bench.graph import alternate, cpu_seconds, graphs, proportional_megabytes
from bench.listener import Listener
from bench.row import at_least, at_most, median_ratio
from mobile_robot_control.ros.shared.qos import SUBSCRIBED


def test_a_row_holds_up_to_its_bound_and_never_with_nan():
    assert at_least('a', 0.8, 0.8, '').holds
    assert not at_least('a', 0.79, 0.8, '').holds
    assert at_most('a', 1.3, 1.3, '').holds
    assert not at_most('a', 1.31, 1.3, '').holds
    assert not at_least('a', math.nan, 0.8, '').holds
    assert not at_most('a', math.nan, 1.3, '').holds


def test_the_median_ratio_ignores_a_slow_pair():
    assert median_ratio([2.0, 200.0, 2.0], [1.0, 100.0, 1.0]) == 2.0


def test_every_benchmark_module_has_rows():
    modules = sorted(path.stem for path in Path(__file__).parent.glob('bench_*.py'))
    assert {'bench_lockstep', 'bench_memory', 'bench_start', 'bench_wall_clock'} <= set(modules)
    for name in modules:
        assert callable(importlib.import_module(f'bench.{name}').rows)


@pytest.mark.parametrize(('second', 'code'), [
    (at_most('second', 1.0, 1.3, ''), 0), (at_most('second', 2.0, 1.3, ''), 1), (KeyboardInterrupt(), 130),
])
def test_measured_rows_are_printed_even_after_an_interrupt(monkeypatch, capsys, second, code):
    module = ModuleType('bench.bench_two')

    def rows():
        yield at_most('first', 1.0, 1.3, '')
        if isinstance(second, BaseException):
            raise second
        yield second

    module.rows = rows
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(__main__, 'modules', lambda names: ['bench_two'])
    assert __main__.main([]) == code
    assert '| first' in capsys.readouterr().out


def test_an_unknown_benchmark_is_refused(capsys):
    with pytest.raises(SystemExit, match='2'):
        __main__.main(['nothing'])
    assert 'lockstep' in capsys.readouterr().err


def test_cpu_time_and_memory_of_this_process_are_measured():
    before, began = cpu_seconds(os.getpid()), time.process_time()
    while time.process_time() < began + 0.05:
        pass
    assert 0.04 < cpu_seconds(os.getpid()) - before < 0.5
    # 100 MB, beside which the shares of libraries that other processes load do not matter
    before, held = proportional_megabytes(os.getpid()), os.urandom(100_000_000)
    assert 90.0 < proportional_megabytes(os.getpid()) - before < 120.0
    del held


def test_the_probe_measures_the_age_of_inputs(monkeypatch, tmp_path):
    """From the moment at which a node is given an input to the moment at which it publishes."""
    now, taken, published = [10.0], [], []
    monkeypatch.setattr(probe.time, 'monotonic', lambda: now[0])
    noted = probe.Probe(str(tmp_path / 'ages'), lambda node, kind, topic, callback, *others: callback,
                        lambda node, kind, topic, *others: SimpleNamespace(publish=published.append))
    node = SimpleNamespace(get_name=lambda: 'position_controller')
    take = noted.create_subscription(node, None, 'odom', taken.append, 1)
    publisher = noted.create_publisher(node, None, 'cmd_vel', 1)
    take('pose')
    now[0] += 0.25
    publisher.publish('command')
    now[0] += 0.5
    publisher.publish('command')
    noted.write()
    assert (taken, published) == (['pose'], ['command', 'command'])
    assert json.loads((tmp_path / 'ages').read_text()) == {'odom': [0.25, 0.75]}


@pytest.mark.soak
def test_one_graph_at_a_time_runs(domain):
    with graphs(2) as both:
        for graph in both:
            graph.start('empty', 'bench.empty_node')
        time.sleep(2.0)
        for _, graph in alternate(both, 2, 0.1):
            spent = {other: cpu_seconds(other.pids['empty']) for other in both}
            time.sleep(0.5)
            for other, before in spent.items():
                assert (cpu_seconds(other.pids['empty']) > before) == (other is graph)
        pids = [graph.pids['empty'] for graph in both]
    assert not [pid for pid in pids if Path(f'/proc/{pid}').exists()]


@pytest.mark.soak
def test_a_node_that_has_ended_is_named(domain):
    with graphs(1) as (graph,):
        graph.start('empty', 'bench.empty_node')
        time.sleep(1.0)
        graph.signal(signal.SIGKILL)
        time.sleep(0.5)
        with pytest.raises(RuntimeError, match='empty'):
            graph.check()


@pytest.mark.soak
def test_bare_nodes_publish_messages_of_the_same_size(domain):
    """Same topics, same types, same bytes in a message."""
    sizes_by_graph = []
    with graphs(4) as (ours, bare, ours_on_the_wall_clock, passing_on):
        bench_lockstep.start(ours, bare)
        bench_wall_clock.start(ours_on_the_wall_clock, passing_on)
        for graph in (ours, bare, ours_on_the_wall_clock, passing_on):
            sizes = {}
            listener = Listener(graph.domain)
            for topic, message in MESSAGES.items():
                listener.listen_to(topic, type(message), lambda raw, sizes=sizes, topic=topic: sizes.update(
                    {topic: len(raw)}), SUBSCRIBED)
            listener.until(lambda sizes=sizes: len(sizes) == len(MESSAGES), 30.0, graph.check)
            sizes_by_graph.append(sizes)
            listener.close()
    assert all(sizes == sizes_by_graph[0] for sizes in sizes_by_graph[1:])


@pytest.mark.soak
@pytest.mark.timeout(300)
def test_every_benchmark_gives_plausible_numbers(domain):
    ours, bare = bench_lockstep.cycles(windows=2, seconds=0.5)
    assert len(ours) == len(bare) == 2
    assert all(10.0 < rate < 1e5 for rate in ours + bare)
    measured = bench_wall_clock.measure(windows=1, seconds=1.5)
    assert set(measured.cpu) == set(bench_wall_clock.PERIODS)
    assert all(0.0 < value[0] < 1.0 for pair in measured.cpu.values() for value in pair)
    assert {len(pair) for pair in measured.ages.values()} == {2}
    # five inputs, whose ages lie within some periods of their topics
    assert len(measured.ages) == 5
    assert all(0.0 < bench_wall_clock.STATISTICS['median'](ages[0]) < 0.1 for pair in measured.ages.values()
               for ages in pair)
    assert all(0.05 < seconds[0] < 20.0 for seconds in bench_start.times(runs=1).values())
    assert all(10.0 < found < 500.0 for found in bench_memory.megabytes(simulated=1.0).values())
