"""A simulation with its files: parameters before the run, a table during it, metrics after it."""

import json
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.configuration.files import save_configuration
from mobile_robot_control.configuration.nodes import Configuration, has_exact_odometry
from mobile_robot_control.configuration.provenance import provenance
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.recording.csv_table import write_csv
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.simulate import Simulated, Simulation, SimulationRequest
from mobile_robot_control.system.files import naming_errors, writable_file, write_atomically
from mobile_robot_control.system.interrupt import Interrupt
from mobile_robot_control.system.progress import tqdm


class SimulationFiles(NamedTuple):
    """The files of a simulation."""

    output: Annotated[str | None, Field('', 'table of the run to write')] = None


def simulate_into_files(
    request: SimulationRequest, files: SimulationFiles, command_line: str
) -> tuple[Simulated, Configuration]:
    """Simulate until the end or an interrupt, and write; return the result, and the configuration."""
    simulation = Simulation(request)
    parameters = simulation.parameters
    with ExitStack() as stack:
        interrupt = stack.enter_context(Interrupt())
        table = None
        if files.output is not None:
            stack.enter_context(naming_errors(Path(files.output)))
            path = writable_file(files.output)
            table = stack.enter_context(path.open('w', encoding='utf-8', newline=''))
            save_configuration(path.with_suffix('.parameters.yaml'), parameters, request.sources.robot)
            path.with_suffix('.metrics.json').unlink(missing_ok=True)

        def written(samples: Iterable[Sample]) -> Iterable[Sample]:
            if table is not None:
                samples = write_csv(samples, table, not has_exact_odometry(parameters.plant))
            # disable=None shows the bar on a terminal only
            shown: Iterable[Sample] = tqdm(samples, total=simulation.steps, disable=None, leave=False)
            return shown

        found = simulation.run(written, lambda: interrupt.requested)
    if files.output is not None:
        content = {**found.metrics, 'provenance': provenance(command_line, parameters)}
        write_atomically(path.with_suffix('.metrics.json'), json.dumps(content, indent=2) + '\n')
    return found, parameters
