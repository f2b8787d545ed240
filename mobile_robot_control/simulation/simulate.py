"""Requested simulations: the loop of given parameters for a time, up to its end or its failure."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import redirect_stdout
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.configuration.sources import ParameterSources
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.metrics import summary
from mobile_robot_control.simulation.rollout import measure, rollout
from mobile_robot_control.simulation.run_length import ONE_RUN, check_run_length

Pipe = Callable[[Iterable[Sample]], Iterable[Sample]]
"""Passes the samples of a run on, with some side effect."""


class SimulationRequest(NamedTuple):
    """The request of a simulation."""

    sources: ParameterSources
    duration: Annotated[float, Field('s', 'simulated time', above=0.0)]


class Simulated(NamedTuple):
    """
    The result of a simulation.

    Attributes
    ----------
    metrics : dict of str to object
        As `metrics.json`.
    failure : str
        Reason of an early end; '' if the run reached its end.

    """

    metrics: dict[str, Any]
    failure: str


class Simulation:
    """
    A simulation, checked and ready to run.

    Parameters
    ----------
    request : SimulationRequest
        The request; ParameterError is raised if it cannot be run.

    Attributes
    ----------
    parameters : Configuration
        Of the run, its duration included.
    steps : int
        Samples of the whole run.

    """

    def __init__(self, request: SimulationRequest) -> None:
        configured = request.sources.configuration()
        rate = configured.plant.shared.velocity_rate
        check_run_length(f'duration = {request.duration:g}', request.duration, rate, ONE_RUN)
        self._configured, self._duration = configured, request.duration
        self.parameters: Configuration = configured._replace(
            plant=configured.plant._replace(duration=request.duration))
        self.steps = round(request.duration * rate) + 1

    def run(self, pipe: Pipe = lambda samples: samples, is_stopped: Callable[[], bool] = lambda: False) -> Simulated:
        """
        Run it.

        Parameters
        ----------
        pipe : callable
            Takes the samples and yields them.
        is_stopped : callable
            Called after every sample; True ends the run.

        Returns
        -------
        Simulated
            Its metrics, and the reason of an early end.

        """
        failures: list[str] = []

        def samples() -> Iterator[Sample]:
            sample = None
            try:
                for sample in rollout(self._configured, self._duration):
                    yield sample
                    if is_stopped():
                        return
            except LawFailedError as error:
                failures.append(str(error))
                raise
            except KeyboardInterrupt:
                # of a step that does not end
                if sample is None or not is_stopped():
                    raise

        # output that a law prints must not mix with the results
        with redirect_stdout(sys.stderr):
            run = measure(self._configured, self._duration, pipe(samples()))
        if is_stopped() and run.outcome == 'diverged':
            run = run._replace(outcome='interrupted')
        metrics = summary(run)
        law = self.parameters.position_controller.control.controller_type
        at = f'at t = {metrics["duration"]} s'
        return Simulated(metrics, {
            'completed': '',
            'interrupted': f'interrupted {at}',
            'diverged': f'the motion diverged {at}; lower the gains or raise the rates',
            'law_failed': f"the position law '{law}' failed {' '.join(failures)}",
        }[run.outcome])
