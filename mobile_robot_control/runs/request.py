"""Requested simulations, and `simulate`: the closed loop in one process."""

import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import redirect_stdout
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.control.velocity_law import VelocityLawFailedError
from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.loop.scenarios import ONE_RUN, check_run_length
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.parameters.requests import make_request, takes_fields
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure, rollout
from mobile_robot_control.settings.configure import File, ParameterSources, parameter_sources
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.settings.provenance import call_text, provenance
from mobile_robot_control.system.progress import tqdm

if TYPE_CHECKING:
    from mobile_robot_control.runs.run import Run

Pipe = Callable[[Iterable[Sample]], Iterable[Sample]]
"""Passes the samples of a run on, with some side effect."""


class SimulationRequest(NamedTuple):
    """The request of a simulation."""

    sources: ParameterSources
    duration: Annotated[float, Field('s', 'simulated time', above=0.0)]


class SimulationResult(NamedTuple):
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

    def run(
        self, pipe: Pipe = lambda samples: samples, is_stopped: Callable[[], bool] = lambda: False
    ) -> SimulationResult:
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
        SimulationResult
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
                kind, node = (('velocity', self.parameters.velocity_controller) if isinstance(
                    error, VelocityLawFailedError) else ('position', self.parameters.position_controller))
                failures.append(f"the {kind} law '{node.control.controller_type}' failed {error}")
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
        at = f'at t = {metrics["duration"]} s'
        return SimulationResult(metrics, {
            'completed': '',
            'interrupted': f'interrupted {at}',
            'diverged': f'the motion diverged {at}; lower the gains or raise the rates',
            'law_failed': ' '.join(failures),
        }[run.outcome])


@takes_fields(SimulationRequest)
def simulate(
    *files: File, duration: float, robot: File | None = None, parameters: Mapping[str, object] | None = None,
    name: str | None = None, progress: bool = False,
) -> 'Run':
    """
    Run the closed loop of the four nodes in this process, as the command `simulate` does, to the same numbers.

    Laws and curves of `register` have their names here, too. By default the robot starts at the cart's start;
    `plant.initial_pose` overrides it.

    Parameters
    ----------
    *files : path
        ROS 2 parameter files, later ones win; without any, the defaults.
    robot : str or path or None
        A robot of this package, or the parameter file of one; read before the files.
    parameters : mapping of str to object or None
        Values by ``NODE.PARAMETER``, which win over the files; ``'/**.position_rate'`` sets a shared one.
    name : str or None
        For legends; if None, that of the position law.
    progress : bool
        Whether to show a progress bar.

    Returns
    -------
    Run
        Up to its end, or until the motion diverged or the law failed; then there is a `RuntimeWarning`, and
        ``metrics['outcome']`` and ``problems`` give the reason.

    Raises
    ------
    ParameterError
        With every violation and its remedy.

    Examples
    --------
    >>> run = simulate(duration=2.0, parameters={'plant.max_wheel_torque': 3.0})
    >>> run.time.shape, run.pose.shape, run.wheel_torque.shape
    ((1001,), (1001, 3), (1001, 2))
    >>> bool(abs(run.wheel_torque).max() <= 3.0), run.metrics['outcome']
    (True, 'completed')

    """
    # imported late: the command starts without NumPy
    from mobile_robot_control.runs.run import Run  # noqa: PLC0415
    from mobile_robot_control.runs.samples import SampleReader  # noqa: PLC0415

    sources = parameter_sources(files, robot, parameters)
    simulation = Simulation(make_request(SimulationRequest, {'sources': sources, 'duration': duration}))
    law = simulation.parameters.position_controller.control.controller_type
    reader = SampleReader()
    metrics, failure = simulation.run(lambda samples: reader.taking(
        tqdm(samples, leave=False, total=simulation.steps, disable=not progress)))
    if failure:
        warnings.warn(failure, RuntimeWarning, stacklevel=2)
    call = call_text('simulate', *files, duration=duration, robot=robot, parameters=parameters)
    return Run(law if name is None else name, reader.series(), tuple(filter(None, [failure])), metrics,
               simulation.parameters, provenance(call, simulation.parameters))
