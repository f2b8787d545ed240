"""The files of a run: found from any path to it, and written."""

import json
import os
from pathlib import Path
from typing import Any

from mobile_robot_control.messages.bag_files import bag_folder
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.runs.csv_table import write_csv
from mobile_robot_control.runs.record import RunRecord
from mobile_robot_control.runs.samples import samples_of
from mobile_robot_control.settings.configure import File
from mobile_robot_control.settings.files import save_configuration
from mobile_robot_control.system.files import (
    METRICS,
    naming_errors,
    parse_json,
    read_bounded,
    writable_file,
    write_atomically,
)
from mobile_robot_control.system.texts import printable, shortened

_BAGS = ('.mcap', '.db3', '.bag')
"""Endings of the files in a bag."""


class UnreadableRunError(ValueError):
    """Raised for a path that is no readable run; the message says what it is, and what to name instead."""


def locate(path: Path) -> Path:
    """
    Return the CSV file, the bag's folder, or the file of a bag without metadata for a path.

    The path is one of these, a file in a bag's folder, or the folder of an experiment; otherwise UnreadableRunError is
    raised.
    """
    # os.path accepts paths that the system refuses
    if not os.path.exists(path):
        raise UnreadableRunError(f'{path}: does not exist; name a bag, a folder of `experiment` or a CSV of `simulate`')
    if path.is_dir():
        if folder := bag_folder(path):
            return folder
        raise UnreadableRunError(f'{path}: is a folder without a bag (no metadata.yaml, .mcap or .db3 in it); '
                                 'name the folder that `experiment` or `ros2 bag record` wrote')
    if path.name == 'metadata.yaml' or (path.suffix in _BAGS and (path.parent / 'metadata.yaml').is_file()):
        return path.parent
    return path


def companion(run: Path, ending: str) -> Path | None:
    """Return a file beside a run: DIR/parameters.yaml beside DIR/bag, FILE.parameters.yaml beside FILE.csv."""
    file = run.parent / ending if run.is_dir() else run.with_suffix(f'.{ending}')
    return file if file.is_file() else None


def is_bag(run: Path) -> bool:
    """Return whether a result of `locate` is a bag, or a file of one, rather than a table."""
    return run.is_dir() or run.suffix in _BAGS


def beside_a_run(file: Path | None) -> tuple[str | None, dict[str, Any]]:
    """Read the outcome and the provenance from a file of metrics; None and {} if they are missing."""
    try:
        content = parse_json(read_bounded(file, METRICS)) if file else {}
    except (OSError, ValueError):
        content = {}
    measured = content if isinstance(content, dict) else {}
    outcome, origin = measured.get('outcome'), measured.get('provenance')
    return shortened(outcome, 40) if isinstance(outcome, str) else None, origin if isinstance(origin, dict) else {}


def name_of(argument: str) -> tuple[str, Path]:
    """
    Read RUN or NAME=RUN; return the run's name and its path.

    Examples
    --------
    >>> name_of('runs/fuzzy/bag')[0], name_of('best=a.csv')[0]
    ('fuzzy', 'best')
    """
    name, separator, place = argument.partition('=')
    # os.path accepts any path, such as a link to itself
    if name and separator and not os.path.exists(argument):
        return name, Path(place)
    path = Path(argument)
    folder = Path(os.path.realpath(argument))
    if folder.name == 'bag':
        folder = folder.parent
    return (folder.stem if os.path.isfile(argument) else folder.name) or argument, path


def save_run(run: RunRecord, file: File) -> None:
    """Write a run, with its parameters and metrics beside it; see `Run.save`."""
    if Path(file).suffix != '.csv':
        raise ParameterError([f'{printable(str(file))}: a run is saved as a table; name a file that ends in .csv'])
    path = writable_file(str(file))
    with naming_errors(path), path.open('w', encoding='utf-8', newline='') as table:
        for _ in write_csv(samples_of(run.series), table, run.series.hides_truth):
            pass
    beside = path.with_suffix('.parameters.yaml')
    if run.parameters is None:
        # files of another run
        beside.unlink(missing_ok=True)
    else:
        save_configuration(beside, run.parameters)
    content = {**run.metrics, 'provenance': run.provenance}
    write_atomically(path.with_suffix('.metrics.json'), json.dumps(content, indent=2) + '\n')
