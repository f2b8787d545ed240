"""An experiment performed: run, recorded and evaluated, watched over by a process of its own."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mobile_robot_control.cli.node_processes import START
from mobile_robot_control.cli.progress import tqdm
from mobile_robot_control.cli.watchdog import Watchdog
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.ros.refusal import LOAD_ERRORS, load_fault

if TYPE_CHECKING:
    from mobile_robot_control.cli.experiment_result import ExperimentResult
    from mobile_robot_control.cli.experiment_runner import Drive


def progress_bar(seconds: float) -> tqdm:
    """Make a bar over the simulated time of all runs [s]."""
    return tqdm(total=seconds, desc='simulated', bar_format='{l_bar}{bar}| {n:.1f}/{total:.1f} s '
                '[{elapsed}<{remaining}]')


def perform(
    options: argparse.Namespace, parameters: Configuration, output: Path, bar: tqdm, unused: list[Path],
    drive: Callable[[], 'Drive'] | None = None,
) -> tuple['ExperimentResult', dict[str, Any]]:
    """Run, record and evaluate one configuration; the reason names all that went wrong."""
    with Watchdog(max(options.patience, START)) as watchdog:
        # imported late: bad usage is reported at once, and an import that hangs is noticed
        try:
            from mobile_robot_control.cli.evaluation import evaluate  # noqa: PLC0415
            from mobile_robot_control.cli.experiment_run import run_experiment  # noqa: PLC0415
        except LOAD_ERRORS as error:
            raise ParameterError([load_fault(error)]) from error

        result = run_experiment(parameters, output, options.namespace, composed=options.composed,
                                patience=options.patience, stop=options.stop, bar=bar, watchdog=watchdog,
                                drive=None if drive is None else drive())
    unused.remove(output)
    bar.set_description('drawing the report' if options.with_report else 'measuring')
    evaluated = evaluate(output, options.namespace, result.outcome, quiet=bool(options.compare),
                         with_report=options.with_report)
    reasons = [*filter(None, [result.reason]), *evaluated.unwritten]
    return result._replace(reason='\nexperiment: '.join(reasons)), evaluated.metrics
