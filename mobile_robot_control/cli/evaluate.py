"""From a recorded run to its metrics and its report."""

import json
import sys
from pathlib import Path
from typing import Any

from mobile_robot_control.cli.report import draw, load_run
from mobile_robot_control.reporting.run_reading import UnreadableRunError


def evaluate(output: Path, namespace: str, outcome: str, quiet: bool = False) -> dict[str, Any]:
    """
    Measure and draw a recorded run.

    Parameters
    ----------
    output : Path
        Folder with the bag and its `parameters.yaml`; takes `metrics.json` and the report.
    namespace : str
        In which the nodes ran.
    outcome : str
        'completed', 'diverged', 'interrupted' or 'node_died'.
    quiet : bool
        Without progress bars.

    Returns
    -------
    dict of str to object
        The metrics, as written.

    """
    metrics: dict[str, Any] = {'outcome': outcome, 'duration': 0.0}
    try:
        run = load_run(output.resolve().name, output / 'bag', namespace, outcome, quiet)
    except UnreadableRunError as error:
        print(f'experiment: no report: {error}', file=sys.stderr)
    else:
        for problem in run.problems:
            print(f'experiment: {problem}', file=sys.stderr)
        metrics |= run.metrics
        draw([run], output, quiet=quiet)
    (output / 'metrics.json').write_text(json.dumps(metrics, indent=2) + '\n', encoding='utf-8')
    return metrics
