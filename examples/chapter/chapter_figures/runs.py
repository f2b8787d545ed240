"""The runs behind the chapter's figures and claims."""

import functools
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mobile_robot_control.control import hybrid_backstepping
from mobile_robot_control.control.hybrid_backstepping import HybridState
from mobile_robot_control.control.laws import select
from mobile_robot_control.control.velocity_loop import velocity_form
from mobile_robot_control.control.velocity_pi import LAW, VelocityGains
from mobile_robot_control.loop.closed_loop import Sample, with_command
from mobile_robot_control.loop.ticks import make_velocity_tick, start
from mobile_robot_control.quantities import BodyVelocity, Observation
from mobile_robot_control.runs.request import simulate
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import Configuration

LAP = 16.0
"""[s]: one lap of either curve."""
BESIDE = (0.8, -0.1, 0.3)
"""A start beside the curve with the cart out of sight: x, y [m], heading [rad]."""
STEP_GAINS = VelocityGains(k1=129.7749, ti1=11.4018, k2=41.0233, ti2=24.1873)
"""Of section 2.2 of the chapter, for its Fig. 3 and 4."""


class ChapterRun(NamedTuple):
    """
    A run of the chapter.

    Attributes
    ----------
    file : str
        Parameter file, under the folder of configurations.
    start : tuple of float
        x, y [m], heading [rad] of the robot; () for that of the file.
    duration : float
        [s].
    """

    file: str
    start: tuple[float, ...] = ()
    duration: float = LAP

    def command(self) -> str:
        """Return the shell commands that make the same run and report it."""
        start = f" -p 'plant.initial_pose:={list(self.start)}'" if self.start else ''
        return (f'mrc simulate --duration {self.duration:g} --params-file config/{self.file}{start} --output run.csv\n'
                'mrc report run.csv --output report')


# three laps, in which the errors fall from lap to lap
ORDINARY_LEMNISCATE = ChapterRun('chapter/lemniscate_backstepping.yaml', BESIDE, 3.0 * LAP)
HYBRID_LEMNISCATE = ChapterRun('chapter/lemniscate_hybrid_backstepping.yaml', BESIDE, 3.0 * LAP)
ORDINARY_TRIFOLIUM = ChapterRun('chapter/trifolium_backstepping.yaml')
FUZZY_TRIFOLIUM = ChapterRun('chapter/trifolium_fuzzy.yaml')
FUZZY_BESIDE = ChapterRun('chapter/trifolium_fuzzy.yaml', BESIDE)


class StepTick(NamedTuple):
    """Time [s], command and measured velocity in a test of the velocity loop alone."""

    time: float
    command: BodyVelocity
    velocity: BodyVelocity


class Runs:
    """
    Makes each run once, at its first use.

    Parameters
    ----------
    config : Path
        Folder of the configurations.
    """

    def __init__(self, config: Path) -> None:
        self._config = config
        self.measured = functools.cache(self._measured)

    def configuration(self, run: ChapterRun) -> Configuration:
        """Return the checked configuration of a run."""
        overrides = [f'plant.initial_pose:={list(run.start)}'] if run.start else []
        return configure(load([self._config / run.file], overrides))

    def _measured(self, run: ChapterRun) -> Run:
        """Run and measure."""
        start = {'plant.initial_pose': list(run.start)} if run.start else None
        return simulate(self._config / run.file, duration=run.duration, parameters=start, name=run.file)

    def velocity_steps(self, steps: tuple[tuple[float, BodyVelocity], ...], duration: float) -> Iterator[StepTick]:
        """
        Run the velocity loop alone, with the gains of section 2.2; yield every period of it.

        Parameters
        ----------
        steps : tuple of (float, BodyVelocity)
            Times [s] from which the commands are given, ascending; before the first the command is zero.
        duration : float
            [s].
        """
        configuration = self.configuration(ORDINARY_TRIFOLIUM)
        controller = configuration.velocity_controller
        controller = controller._replace(control=controller.control._replace(gains=STEP_GAINS))
        loop, state = start(configuration._replace(velocity_controller=controller))
        velocity_tick = make_velocity_tick(velocity_form(LAW, feeds=False))
        rate = configuration.plant.shared.velocity_rate
        for k in range(round(duration * rate)):
            command = next((value for at, value in reversed(steps) if k / rate >= at), BodyVelocity(0.0, 0.0))
            yield StepTick(k / rate, command, state.robot.motion.velocity)
            state, _, _ = velocity_tick(with_command(state, command), k, loop)

    def seeking(self, run: ChapterRun, duration: float) -> Iterator[tuple[Sample, HybridState]]:
        """Run a hybrid law over a duration [s]; yield each position tick and the law's state before its step."""
        configuration = self.configuration(run)
        dt = 1.0 / configuration.plant.shared.position_rate
        _, gains = select(configuration.position_controller.control, dt)
        state = HybridState()
        for sample in rollout(configuration, duration):
            tick = sample.tick
            if tick.time == sample.time:
                yield sample, state
                # the law is a pure function: the same inputs lead to the same state as in the rollout
                observation = Observation(tick.error, tick.reference, tick.velocity)
                state, _ = hybrid_backstepping.step(state, observation, gains, dt)
