"""The search on a real Dask cluster of two workers, one of which is killed: the result is the same."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.processes import wait_until

from mobile_robot_control.loop import batch
from mobile_robot_control.loop.scenarios import configured_scenario
from mobile_robot_control.parameters.plugins import load_plugins
from mobile_robot_control.search.objective import Goal, Objective
from mobile_robot_control.search.search import SearchSettings, run_search
from mobile_robot_control.search.space import bounded, search_genes
from mobile_robot_control.settings.configure import configure

KANAYAMA = Path(__file__).parents[1] / 'plugins' / 'kanayama.py'
distributed = pytest.importorskip('distributed')

# a worker without numba: the compilation would take longer than all else
WORKER = ('import sys; sys.modules["numba"] = None; from distributed.cli.dask_worker import main; '
          'sys.argv = ["worker", *sys.argv[1:]]; main()')
SCHEDULER = ('import sys; from distributed.cli.dask_scheduler import main; '
             'sys.argv = ["scheduler", *sys.argv[1:]]; main()')


def start(code, *arguments):
    return subprocess.Popen([sys.executable, '-c', code, *arguments], stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL)


@pytest.fixture
def cluster(tmp_path):
    """A scheduler and two workers as processes of their own; gives the address and the workers."""
    scheduler_file = tmp_path / 'scheduler.json'
    local = ('--host', '127.0.0.1', '--port', '0', '--no-dashboard')
    processes = [start(SCHEDULER, *local, '--scheduler-file', str(scheduler_file))]
    try:
        wait_until(scheduler_file.exists, 60.0)
        # a nanny would start a killed worker again
        processes += [start(WORKER, '--scheduler-file', str(scheduler_file), '--nthreads', '1', '--no-nanny',
                            '--no-dashboard', '--local-directory', str(tmp_path)) for _ in range(2)]
        with distributed.Client(scheduler_file=str(scheduler_file), set_as_default=False) as client:
            wait_until(lambda: len(client.scheduler_info(n_workers=-1)['workers']) == 2, 60.0)
            yield client.scheduler.address, processes[1:]
    finally:
        for process in processes:
            process.kill()
            process.wait()


@pytest.mark.soak
@pytest.mark.parametrize('law', ['backstepping', 'my_kanayama'])
def test_a_killed_worker_does_not_change_the_result(cluster, monkeypatch, registered, law):
    from mobile_robot_control.loop.workers import Cluster
    monkeypatch.setattr(batch, 'COMPILES', False)
    # the workers have never seen the file of the law
    load_plugins({'law': [str(KANAYAMA)]})
    address, workers = cluster
    parameters = configure({'reference_cart': {'period': 1.0, 'scale': 0.1}})
    genes = bounded(search_genes(law), {'gains.k1': (0.0, 2.0), 'k2': (0.0, 2.0)})
    goal = Goal(law, genes, (configured_scenario(parameters),))
    settings = SearchSettings('genetic', len(genes), 21, 8, 1)
    alone = run_search(settings, Objective(parameters, goal, lambda trials: batch.run_trials(trials, False)))
    remote, done = Cluster(address), []

    def run(trials):
        # in the midst of the third generation
        if len(done) == 2:
            os.kill(workers[0].pid, signal.SIGKILL)
        done.append(len(trials))
        return remote(trials)

    try:
        together = run_search(settings, Objective(parameters, goal, run))
    finally:
        remote.close()
    assert workers[0].wait() == -signal.SIGKILL
    assert workers[1].poll() is None
    assert (together.score, together.history) == (alone.score, alone.history)
    assert (together.point == alone.point).all()


@pytest.mark.soak
def test_a_cluster_that_stays_without_workers_raises(cluster):
    from mobile_robot_control.loop.workers import Cluster
    address, workers = cluster
    remote = Cluster(address, patience=2.0)
    try:
        for worker in workers:
            worker.kill()
        with pytest.raises(OSError, match=f'the cluster at {address} has no workers any more; start some'):
            remote.each(abs, [0.0], '')
    finally:
        remote.close()
