"""`simulate`: the closed loop in this process, as arrays."""

import warnings
from collections.abc import Mapping

from mobile_robot_control.parameters.requests import make_request
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import SampleReader
from mobile_robot_control.runs.simulation import Simulation, SimulationRequest
from mobile_robot_control.settings.configure import File, parameter_sources
from mobile_robot_control.settings.provenance import call_text, provenance
from mobile_robot_control.system.progress import tqdm


def simulate(
    *files: File, duration: float, robot: File | None = None, parameters: Mapping[str, object] | None = None,
    name: str | None = None, progress: bool = False,
) -> Run:
    """
    Run the closed loop of the four nodes in this process, as the command `simulate` does, to the same numbers.

    Laws and curves of `register` have their names here, too. By default the robot starts at the cart's start;
    `plant.initial_pose` overrides it.

    Parameters
    ----------
    *files : path
        ROS 2 parameter files, later ones win; without any, the defaults.
    duration : float
        Simulated time [s].
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
