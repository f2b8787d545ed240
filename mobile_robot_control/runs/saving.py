"""A run written as the table that `simulate` writes."""

import json
from pathlib import Path

from mobile_robot_control.configuration.files import configuration_text
from mobile_robot_control.configuration.sources import File
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.recording.csv_table import write_csv
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import samples_of
from mobile_robot_control.system.files import naming_errors, writable_file, write_atomically
from mobile_robot_control.system.texts import printable


def save_run(run: Run, file: File) -> None:
    """Write a run, with its parameters and metrics beside it; see `Run.save`."""
    if Path(file).suffix != '.csv':
        raise ParameterError([f'{printable(str(file))}: a run is saved as a table; name a file that ends in .csv'])
    path = writable_file(str(file))
    with naming_errors(path), path.open('w', encoding='utf-8', newline='') as table:
        for _ in write_csv(samples_of(run.series), table, run.series.hides_truth):
            pass
    beside = path.with_suffix('.parameters.yaml')
    if run.parameters is None:
        # those of another run
        beside.unlink(missing_ok=True)
    else:
        write_atomically(beside, configuration_text(run.parameters))
    content = {**run.metrics, 'provenance': run.provenance}
    write_atomically(path.with_suffix('.metrics.json'), json.dumps(content, indent=2) + '\n')
