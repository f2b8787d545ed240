"""`simulate`: the closed loop in this process, as arrays."""

import warnings
from collections.abc import Iterable, Iterator, Mapping

from mobile_robot_control.api.command_lines import File, option_arguments, parsed, shared_arguments
from mobile_robot_control.api.runs import Run
from mobile_robot_control.api.sample_rows import SampleRows
from mobile_robot_control.cli.options import configuration
from mobile_robot_control.cli.progress import tqdm
from mobile_robot_control.cli.run_length import ONE_RUN, check_run_length
from mobile_robot_control.cli.simulate import noting_failure, outcome_text, parse_simulate
from mobile_robot_control.recording.collector import Collector
from mobile_robot_control.reporting.series import Series
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.metrics import summary
from mobile_robot_control.simulation.rollout import measure, rollout


def _collecting(samples: Iterable[Sample], collector: Collector) -> Iterator[Sample]:
    """Yield samples, and collect their topics."""
    for sample in samples:
        collector.add_sample(sample)
        yield sample


def simulate(
    *files: File, duration: float, robot: File | None = None, parameters: Mapping[str, object] | None = None,
    name: str | None = None, progress: bool = False,
) -> Run:
    """
    Run the closed loop of the four nodes in this process, as the command `simulate` does, to the same numbers.

    Laws and curves of `register` have their names here too. The robot starts at the cart's start, unless
    `plant.initial_pose` is given.

    Parameters
    ----------
    *files : path
        ROS 2 parameter files, later ones win; without any, the defaults.
    duration : float
        Simulated time [s].
    robot : str or path or None
        One of the robots of this package, or the parameter file of one; read before the files.
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
        ``metrics['outcome']`` and ``problems`` tell why.

    Raises
    ------
    ParameterError
        Naming every violation, with the remedy.

    Examples
    --------
    >>> run = simulate(duration=2.0, parameters={'plant.max_wheel_torque': 3.0})
    >>> run.time.shape, run.pose.shape, run.wheel_torque.shape
    ((1001,), (1001, 3), (1001, 2))
    >>> bool(abs(run.wheel_torque).max() <= 3.0), run.metrics['outcome']
    (True, 'completed')

    """
    options = parsed(parse_simulate, [*shared_arguments(files, robot, parameters),
                                      *option_arguments({'duration': duration})])
    chosen = configuration(options)
    rate = chosen.plant.shared.velocity_rate
    check_run_length(f'duration = {options.duration:g}', options.duration, rate, ONE_RUN)
    law = chosen.position_controller.control.controller_type
    rows, collector = SampleRows(), Collector()
    failures: list[str] = []
    with tqdm(rows.taking(noting_failure(rollout(chosen, options.duration), failures)), leave=False,
              total=round(options.duration * rate) + 1, disable=not progress) as samples:
        metrics = summary(measure(chosen, options.duration, _collecting(samples, collector)))
    why = outcome_text(metrics, law, failures)
    if why:
        warnings.warn(why, RuntimeWarning, stacklevel=2)
    ran_with = chosen._replace(plant=chosen.plant._replace(duration=options.duration))
    series = Series(collector.signals)
    return Run(name=law if name is None else name, **rows.arrays(series), metrics=metrics, parameters=ran_with,
               problems=tuple(filter(None, [why])), series=series)
