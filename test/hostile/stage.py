"""Lets cases run: makes their folders and samples, sends them to the arena, and judges the answers."""

import json
import os
import subprocess
import sys
from pathlib import Path

from helpers.bag_making import record

from hostile.case import Place, listing, make_case, make_place
from hostile.judging import faults
from hostile.kinds import KINDS
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.search.journal import Journal
from mobile_robot_control.settings.nodes import Configuration

ROOT = Path(__file__).parents[2]


def make_samples(folder):
    """Make the sound files that cases spoil; returns their folder."""
    folder.mkdir(parents=True)
    assert simulate.main(['--duration', '0.1', '--output', str(folder / 'run.csv')]) == 0
    (folder / 'parameters.yaml').write_bytes((folder / 'run.parameters.yaml').read_bytes())
    record(folder / 'bag', rollout(Configuration(), 0.1))
    Journal(folder / 'search.yaml.journal', {'seed': 1}, resume=False).close()
    return folder


class Stage:
    """An arena and the folder of the present case; commands are interrupted after `longest` [s], or their own time."""

    def __init__(self, folder):
        self._folder = folder
        self._samples = make_samples(folder / 'samples')
        self._arenas, self.longest = {}, float('inf')

    def _ask(self, request):
        state = 'cold' if request['cold'] or request['process'] else 'warm'
        if state not in self._arenas:
            self._arenas[state] = subprocess.Popen(
                [sys.executable, '-B', '-m', 'hostile.arena', state], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                text=True, env=os.environ | {'PYTHONPATH': os.pathsep.join(map(str, (ROOT, ROOT / 'test')))})
        arena = self._arenas[state]
        arena.stdin.write(json.dumps(request) + '\n')
        arena.stdin.flush()
        answer = arena.stdout.readline()
        assert answer, f'the arena ended with {arena.wait()}'
        return json.loads(answer)

    def draw(self, seed):
        """Return the case of a seed."""
        return make_case(KINDS, seed, make_place(self._folder / 'case', self._samples))

    def play(self, seed):
        """Run the case of a seed; returns the case, the answer with its `printed`, and how it breaks the rule."""
        case = self.draw(seed)
        place = Place(self._folder / 'case', self._samples)
        environment = {'HOME': str(place.folder / 'home'), 'TMPDIR': str(place.folder / 'tmp'),
                       'ROS_LOG_DIR': str(place.out), 'PYTHONDONTWRITEBYTECODE': '1',
                       # the caches of fonts and of compiled rollouts, which are written once for all cases
                       'MPLCONFIGDIR': str(self._folder / 'matplotlib'),
                       'XDG_CACHE_HOME': str(self._folder / 'cache')} | case.environment
        before = listing(place)
        printed = self._folder / 'printed'
        answer = self._ask({**case._asdict(), 'seconds': min(case.seconds, self.longest), 'environment': environment,
                            'cwd': str(place.here), 'printed': str(printed)})
        answer['printed'] = Path(f'{printed}.stderr').read_text(errors='replace')
        if case.gone:
            del before[str(place.here)]
        return case, answer, faults(case, answer, answer['printed'], before, listing(place))

    def close(self):
        """End the arena."""
        for arena in self._arenas.values():
            arena.stdin.close()
            arena.wait()
            arena.stdout.close()
