"""From a recorded run to its metrics and its picture."""

import json
import sys
from pathlib import Path
from typing import Any

from mobile_robot_control.configuration import Configuration
from mobile_robot_control.recording import bag
from mobile_robot_control.recording.signals import joined
from mobile_robot_control.reporting import run_picture
from mobile_robot_control.simulation.closed_loop import is_complete
from mobile_robot_control.simulation.metrics import RunMeter, summary


def evaluate(parameters: Configuration, output: Path, namespace: str, outcome: str) -> dict[str, Any]:
    """
    Measure and draw a recorded run.

    Parameters
    ----------
    parameters : Configuration
        It ran with.
    output : Path
        Folder with the bag; takes `metrics.json` and `run.png`.
    namespace : str
        In which the nodes ran.
    outcome : str
        'completed', 'diverged', 'interrupted' or 'node_died'.

    Returns
    -------
    dict of str to object
        The metrics, as written.

    """
    recording = bag.read(output / 'bag', namespace)
    for problem in recording.problems:
        print(f'experiment: the recording has gaps: {problem}', file=sys.stderr)
    shared, plant = parameters.plant.shared, parameters.plant
    meter = RunMeter(1.0 / shared.velocity_rate, 1.0 / shared.position_rate)
    for sample in joined(recording.signals):
        meter.add(sample)
    if meter.last is None:
        metrics: dict[str, Any] = {'outcome': outcome, 'duration': 0.0}
    else:
        if outcome == 'completed' and not is_complete(meter.last, plant.duration, shared.velocity_rate):
            print(f'experiment: the recording ends at t = {meter.last.time} s', file=sys.stderr)
        metrics = summary(meter.run(outcome))
        title = (f'{parameters.position_controller.control.controller_type.replace("_", " ")}, '
                 f'{parameters.reference_cart.curve.curve}')
        run_picture.draw(recording.samples, title, output / 'run.png')
    (output / 'metrics.json').write_text(json.dumps(metrics, indent=2) + '\n', encoding='utf-8')
    return metrics
