"""The runs that the chapter's figures and claims are made from."""

import functools
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.control import hybrid_backstepping
from mobile_robot_control.control.hybrid_backstepping import HybridGains, HybridState
from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.parameters.configuration import configure
from mobile_robot_control.parameters.files import load
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.recording.collector import Collector
from mobile_robot_control.reporting.series import Series
from mobile_robot_control.simulation.closed_loop import Sample, velocity_tick
from mobile_robot_control.simulation.metrics import RunMeter, summary
from mobile_robot_control.simulation.rollout import rollout, start

LAP = 16.0
"""[s]: one lap of either curve."""
BESIDE = '[0.8, -0.1, 0.3]'
"""A start beside the curve from which the cart is not in sight: x, y [m], heading [rad]."""
STEP_GAINS = VelocityGains(k1=129.7749, ti1=11.4018, k2=41.0233, ti2=24.1873)
"""Of section 2.2 of the chapter, for its Fig. 3 and 4."""


class ChapterRun(NamedTuple):
    """
    A run of the chapter.

    Attributes
    ----------
    file : str
        Parameter file, under the folder of configurations.
    start : str
        Start x, y [m], heading [rad]; that of the file where it is empty.
    duration : float
        [s].

    """

    file: str
    start: str = ''
    duration: float = LAP

    def command(self) -> str:
        """
        Give the command that makes the same run.

        Returns
        -------
        str
            For a shell.

        """
        start = f" -p 'plant.initial_pose:={self.start}'" if self.start else ''
        return (f'simulate --duration {self.duration:g} --params-file config/{self.file}{start} --output run.csv\n'
                'report run.csv --output report')


# three laps, to see the errors fall from lap to lap
ORDINARY_LEMNISCATE = ChapterRun('chapter/lemniscate_backstepping.yaml', BESIDE, 3.0 * LAP)
HYBRID_LEMNISCATE = ChapterRun('chapter/lemniscate_hybrid_backstepping.yaml', BESIDE, 3.0 * LAP)
ORDINARY_TRIFOLIUM = ChapterRun('chapter/trifolium_backstepping.yaml')
FUZZY_TRIFOLIUM = ChapterRun('chapter/trifolium_fuzzy.yaml')
FUZZY_BESIDE = ChapterRun('chapter/trifolium_fuzzy.yaml', BESIDE)


class Measured(NamedTuple):
    """
    A run that has been run.

    Attributes
    ----------
    configuration : Configuration
        It ran with.
    series : Series
        Its topics.
    metrics : dict of str to object
        As `simulate --json` prints them.

    """

    configuration: Configuration
    series: Series
    metrics: dict[str, Any]


class StepTick(NamedTuple):
    """Time [s], what is asked for and what is measured, in a test of the velocity loop alone."""

    time: float
    asked: BodyVelocity
    velocity: BodyVelocity


class Runs:
    """
    Makes each run once, when it is first asked for.

    Parameters
    ----------
    config : Path
        Folder of the configurations.

    """

    def __init__(self, config: Path) -> None:
        self._config = config
        self.measured = functools.cache(self._measured)

    def configuration(self, run: ChapterRun) -> Configuration:
        """
        Read what a run is to run with.

        Parameters
        ----------
        run : ChapterRun
            Of the chapter.

        Returns
        -------
        Configuration
            Checked.

        """
        overrides = [f'plant.initial_pose:={run.start}'] if run.start else []
        return configure(load([self._config / run.file], overrides))

    def _measured(self, run: ChapterRun) -> Measured:
        """Run and measure."""
        configuration = self.configuration(run)
        shared = configuration.plant.shared
        meter = RunMeter(1.0 / shared.velocity_rate, 1.0 / shared.position_rate)
        collector = Collector()
        for sample in rollout(configuration, run.duration):
            meter.add(sample)
            collector.add_sample(sample)
        return Measured(configuration, Series(collector.signals), summary(meter.run('completed')))

    def velocity_steps(self, steps: tuple[tuple[float, BodyVelocity], ...], duration: float) -> Iterator[StepTick]:
        """
        Drive the velocity loop alone, without a position law.

        Parameters
        ----------
        steps : tuple of (float, BodyVelocity)
            From which time [s] on what is asked for, in order of time; nothing before the first.
        duration : float
            [s].

        Yields
        ------
        StepTick
            One for each period of the velocity loop.

        """
        configuration = self.configuration(ORDINARY_TRIFOLIUM)
        controller = configuration.velocity_controller._replace(gains=STEP_GAINS)
        loop, state = start(configuration._replace(velocity_controller=controller))
        rate = configuration.plant.shared.velocity_rate
        for k in range(round(duration * rate)):
            asked = next((value for at, value in reversed(steps) if k / rate >= at), BodyVelocity(0.0, 0.0))
            yield StepTick(k / rate, asked, state.plant.velocity)
            state, _, _ = velocity_tick(state._replace(command=asked), k, loop)

    def seeking(self, run: ChapterRun, duration: float) -> Iterator[tuple[Sample, HybridState]]:
        """
        Run a hybrid law and tell what it remembers.

        Parameters
        ----------
        run : ChapterRun
            Of a hybrid law.
        duration : float
            [s].

        Yields
        ------
        tuple of Sample and HybridState
            At each position tick, the law's state before its step.

        """
        configuration = self.configuration(run)
        control = configuration.position_controller.control
        gains = HybridGains(control.backstepping, control.hybrid_backstepping)
        dt = 1.0 / configuration.plant.shared.position_rate
        state = HybridState()
        for sample in rollout(configuration, duration):
            tick = sample.tick
            if tick.time == sample.time:
                yield sample, state
                # the law is pure: stepping it again on what it saw gives what it remembered
                state, _ = hybrid_backstepping.step(state, tick.error, tick.reference, gains, dt)
