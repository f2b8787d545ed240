"""One cell of a benchmark, a law on a track with one seed: its inputs, its scenarios, and its result as a file."""

import json
import math
import zlib
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.loop.monte_carlo import JudgedRuns, ScenarioDistribution, draw_scenarios
from mobile_robot_control.loop.scenarios import Scenario, configured_scenario
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose
from mobile_robot_control.search import space
from mobile_robot_control.search.space import Gains
from mobile_robot_control.search.stages import WIDENINGS, Plan
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.settings.tracks import Track
from mobile_robot_control.system.files import FileKind, parse_json, read_bounded, write_atomically
from mobile_robot_control.system.texts import printable
from mobile_robot_control.version import __version__

JUDGED = ('rms_position_error', 'max_position_error', 'settling_time', 'peak_wheel_torque', 'energy',
          'torque_variation', 'command_variation')
"""The metrics that are kept of every run."""
SEARCHED, CONFIGURED, FED = 'searched', 'configured', 'feedforward'
"""Gains of a result: those of a search, those configured, and those of a search with feedforward."""
NOT_SEARCHED = 'not searched'
"""First words of the reason of a result whose search could drive no candidate."""
_RESULT = FileKind('cell', 1 << 30)


class Cell(NamedTuple):
    """
    One cell.

    Attributes
    ----------
    law : str
        Its name.
    track : Track
        What is driven.
    seed : int
        Of the draw of both kinds of scenarios, and of the search.
    budgets : tuple of int
        Candidates of each search of a law with at most 12 gains, ascending; () where gains are taken as configured.
    training, runs : int
        Scenarios of the search, and those that judge.
    restarts : int
        Searches with other seeds, in the last bounds.
    objective : str
        What they minimise; of OBJECTIVES.
    feedforward : bool
        Whether gains are searched and judged with feedforward.
    more : ParameterSources
        Parameters on top of those of the track.
    """

    law: str
    track: Track
    seed: int
    budgets: tuple[int, ...]
    training: int
    runs: int
    restarts: int
    objective: str
    feedforward: bool
    more: ParameterSources = ParameterSources()

    def inputs(self) -> dict[str, Any]:
        """Return all that the result depends on, for JSON."""
        return {'version': __version__, 'arithmetic': ARITHMETIC, 'law': self.law,
                'source': LAWS.checksum(self.law), 'track': self.track.name,
                'content': self.track.content(self.more), 'seed': self.seed, 'budgets': self.budgets,
                'training': self.training, 'runs': self.runs, 'restarts': self.restarts, 'objective': self.objective,
                'feedforward': self.feedforward}

    def file(self, folder: Path) -> Path:
        """Return where its result is kept: the name changes with the inputs."""
        digest = sha256(json.dumps(self.inputs(), sort_keys=True).encode()).hexdigest()[:12]
        fed = '.feedforward' * self.feedforward
        name = printable(f'{self.law}.{self.track.name}{fed}').replace('/', '_')
        return folder / f'{name}.{self.seed}.{digest}.json'

    def configuration(self) -> Configuration:
        """Return the loop with the law, its gains as configured, and with the horizon that it declares."""
        return self.sources().with_values({'/**.feedforward.enabled': self.feedforward}).configuration()

    def sources(self) -> ParameterSources:
        """Return the parameters of its loop: those of the track, with the law and the horizon that it declares."""
        return self._with_horizon().with_values({'position_controller.controller_type': self.law})

    def _with_horizon(self) -> ParameterSources:
        given, horizon = self.track.sources(self.more), LAWS[self.law].horizon
        if horizon and horizon > given.configuration().plant.shared.reference_horizon:
            given = given.with_values({'/**.reference_horizon': horizon})
        return given

    def refused_horizon(self) -> str:
        """Return why the track does not give the horizon that the law declares; '' if it does."""
        try:
            self._with_horizon().configuration()
        except ParameterError as error:
            return f'no horizon of {LAWS[self.law].horizon} ticks: {"; ".join(dict.fromkeys(error.violations))}'
        return ''

    @property
    def rollouts(self) -> int:
        """How many rollouts it has at most."""
        searches = Plan(WIDENINGS, self.restarts).searches * sum(self.budgets)
        return searches * self.training + self.runs * max(1, len(self.budgets)) + self.runs * self.is_compared

    @property
    def is_compared(self) -> bool:
        """Whether its gains as configured are judged, too."""
        return bool(self.budgets) and not self.feedforward

    def drawn(self, use: str, configuration: Configuration, count: int) -> list[Scenario]:
        """Draw scenarios for a use, 'training' or 'judging', whose seeds have nothing in common; of all laws alike."""
        nominal, asked = configured_scenario(configuration), self.track.parameters
        low, high = asked.delays or (nominal.delay, nominal.delay)
        spread = ScenarioDistribution(asked.curves, asked.scales, asked.within or 1.0, asked.variation, nominal.noise,
                                      high - low)
        return [scenario._replace(start=_scaled(scenario.start, asked.within, asked.turned),
                                  delay=low + scenario.delay)
                for scenario in draw_scenarios(spread, count, self.seed_of(use))]

    def seed_of(self, use: str) -> int:
        """Return the seed of a use, which depends on that of the benchmark and on the track."""
        return int.from_bytes(sha256(f'{self.seed} {self.track.name} {use}'.encode()).digest()[:8], 'big')


def _scaled(start: Pose | None, within: float, turned: float) -> Pose:
    """Return a start that was drawn facing anywhere, turned by so much at most."""
    assert start is not None  # noqa: S101 (for mypy: drawn ones have a start)
    if not within:
        start = start._replace(x=0.0, y=0.0)
    return start._replace(heading=start.heading * turned / math.pi)


def write_result(file: Path, result: Mapping[str, Any]) -> None:
    """Write the result of a cell, with its checksum."""
    write_atomically(file, json.dumps({'arithmetic': ARITHMETIC, 'checksum': _checksum(result), 'cell': result}))


def read_result(file: Path) -> dict[str, Any]:
    """Read the result of a cell; raise OSError or ValueError if it is not one that was written."""
    content = parse_json(read_bounded(file, _RESULT))
    if not isinstance(content, dict) or content.get('checksum') != _checksum(content.get('cell')):
        raise ValueError('its checksum is wrong')
    result: dict[str, Any] = content['cell']
    return result


def check_arithmetic(file: Path) -> None:
    """Raise ParameterError if a cell was computed with another arithmetic."""
    try:
        read_result(file)
    except (OSError, ValueError):  # damaged: told where it is needed
        return
    found = parse_json(read_bounded(file, _RESULT)).get('arithmetic', 1)
    if found != ARITHMETIC:
        raise ParameterError([f'{file}: was computed with arithmetic {found}, and this program has {ARITHMETIC}: their '
                              'last bits differ; --overwrite begins anew, or name another --output'])


def _checksum(result: object) -> int:
    return zlib.crc32(json.dumps(result).encode())


def judged_runs(result: Mapping[str, Any]) -> JudgedRuns:
    """Return the judged runs of a result; a value that is not known is infinite."""
    columns = [np.array([math.inf if value is None else value for value in result[name]]) for name in JUDGED]
    return JudgedRuns(np.array(result['success'], bool), dict(zip(JUDGED, columns, strict=True)),
                      np.array(result['outcome'], str))


def was_searched(result: Mapping[str, Any]) -> bool:
    """Return whether a result, or a row of the table, is of gains: no search may have found any that can be driven."""
    return not result['reason'].startswith(NOT_SEARCHED)


def runs_of(result: Mapping[str, Any], runs: int) -> JudgedRuns | None:
    """Return the judged runs of a result: none of gains that no search found, failures of a law that cannot run."""
    if 'success' in result:
        return judged_runs(result)
    if not was_searched(result):
        return None
    return JudgedRuns(np.zeros(runs, bool), {name: np.full(runs, math.inf) for name in JUDGED},
                      np.full(runs, 'law_failed'))


def gains_of(cell: Cell, result: Mapping[str, Any]) -> Gains:
    """Return the gains of a result, exactly as they were judged."""
    return space.configured_gains(cell.sources().with_values(result['gains']).configuration())
