"""One cell of a benchmark, a law or a node on a track with one seed: its inputs and its scenarios."""

import json
import math
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.experiment.foreign_nodes import ForeignNode
from mobile_robot_control.loop.monte_carlo import ScenarioDistribution, draw_scenarios
from mobile_robot_control.loop.scenarios import Scenario, configured_scenario
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose
from mobile_robot_control.search.stages import WIDENINGS, StagePlan
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.settings.tracks import Track
from mobile_robot_control.system.texts import printable
from mobile_robot_control.version import __version__


class Cell(NamedTuple):
    """
    One cell.

    Attributes
    ----------
    law : str
        Its name; of a node, that of its row.
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
    velocity_law : str
        Name of the law of the wheel torques; '' for that which the parameters select.
    node : ForeignNode or None
        Somebody else's position controller, which no search tunes; None for a law.
    repeats : bool
        Whether the first scenario of a node is driven again, to see whether its runs are exact.
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
    velocity_law: str = ''
    node: ForeignNode | None = None
    repeats: bool = False

    @property
    def name(self) -> str:
        """The name of its law in the table, with that of its velocity law where several compete."""
        return f'{self.law}+{self.velocity_law}' if self.velocity_law else self.law

    def inputs(self) -> dict[str, Any]:
        """Return all that the result depends on, for JSON."""
        common = {'version': __version__, 'arithmetic': ARITHMETIC, 'law': self.law, 'track': self.track.name,
                  'content': self.track.content(self.more), 'seed': self.seed}
        # a file with some runs of a node may get more of them
        own = {'node': self.node} if self.node else {
            'source': LAWS.checksum(self.law), 'budgets': self.budgets, 'training': self.training, 'runs': self.runs,
            'restarts': self.restarts, 'objective': self.objective, 'feedforward': self.feedforward}
        return {**common, **own,
                **({'velocity_law': [self.velocity_law, VELOCITY_LAWS.checksum(self.velocity_law)]}
                   if self.velocity_law else {})}

    def file(self, folder: Path) -> Path:
        """Return where its result is kept: the name changes with the inputs."""
        digest = sha256(json.dumps(self.inputs(), sort_keys=True).encode()).hexdigest()[:12]
        fed = '.feedforward' * self.feedforward
        name = printable(f'{self.name}.{self.track.name}{fed}').replace('/', '_')
        return folder / f'{name}.{self.seed}.{digest}.json'

    def configuration(self) -> Configuration:
        """Return the loop with the law, its gains as configured, and with the horizon that it declares."""
        return self.sources().with_values({'/**.feedforward.enabled': self.feedforward}).configuration()

    def sources(self) -> ParameterSources:
        """Return the parameters of its loop: those of the track, with the law and the horizon that it declares."""
        chosen = {} if self.node else {'position_controller.controller_type': self.law}
        if self.velocity_law:
            chosen['velocity_controller.controller_type'] = self.velocity_law
        return self._with_horizon().with_values(chosen)

    @property
    def horizon(self) -> int:
        """How far its law looks ahead [position ticks]."""
        return 0 if self.node else LAWS[self.law].horizon

    def _with_horizon(self) -> ParameterSources:
        sources, horizon = self.track.sources(self.more), self.horizon
        if horizon and horizon > sources.configuration().plant.shared.reference_horizon:
            sources = sources.with_values({'/**.reference_horizon': horizon})
        return sources

    def refused_horizon(self) -> str:
        """Return why the track does not give the horizon that the law declares; '' if it does."""
        try:
            self._with_horizon().configuration()
        except ParameterError as error:
            return f'no horizon of {self.horizon} ticks: {"; ".join(dict.fromkeys(error.violations))}'
        return ''

    @property
    def rollouts(self) -> int:
        """How many rollouts it has at most; a node has none."""
        if self.node:
            return 0
        searches = StagePlan(WIDENINGS, self.restarts).searches * sum(self.budgets)
        return searches * self.training + self.runs * max(1, len(self.budgets)) + self.runs * self.is_compared

    @property
    def is_compared(self) -> bool:
        """Whether its gains as configured are judged, too."""
        return bool(self.budgets) and not self.feedforward

    def drawn(self, use: str, configuration: Configuration, count: int) -> list[Scenario]:
        """Draw scenarios for a use, 'training' or 'judging', whose seeds have nothing in common; of all laws alike."""
        nominal, track = configured_scenario(configuration), self.track.parameters
        low, high = track.delays or (nominal.delay, nominal.delay)
        spread = ScenarioDistribution(track.curves, track.scales, track.within or 1.0, track.variation, nominal.noise,
                                      high - low)
        return [scenario._replace(start=_scaled(scenario.start, track.within, track.turned),
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
