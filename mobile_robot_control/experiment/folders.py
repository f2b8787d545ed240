"""The folders of experiments: prepared for a run, and restored if it is refused."""

import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.waypoint_files import YAML_SUFFIXES
from mobile_robot_control.settings.files import save_configuration
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.settings.provenance import provenance
from mobile_robot_control.system.files import write_atomically

_REPLACED = '.replaced'
"""Within an experiment's folder: holds the previous experiment until the new one has run."""
WRITTEN = ('bag', 'log', 'parameters.yaml', *(f'parameters.waypoints{ending}' for ending in ('.csv', *YAML_SUFFIXES)),
           'metrics.json', 'report.html', 'report.json', 'figures')


@contextmanager
def experiment_folders(
    chosen: Mapping[Path, Configuration], overwrite: bool, robot: str | None = None
) -> Iterator[list[Path]]:
    """
    Prepare a folder for each experiment; only files of experiments are ever removed.

    Parameters
    ----------
    chosen : mapping of Path to Configuration
        The configuration of each experiment.
    overwrite : bool
        Whether to replace experiments in the folders.
    robot : str or None
        Name of the robot, at the head of `parameters.yaml`.

    Yields
    ------
    list of Path
        The folders without a run: remove one from the list once its run has ended. After a ParameterError or an
        OSError, the remaining folders are restored: new files are removed, and replaced ones return.

    Raises
    ------
    ParameterError
        If a folder holds an experiment and may not be overwritten; then none is changed.

    """
    held = [output for output in chosen if any(_written(output))]
    if held and not overwrite:
        raise ParameterError(f'{output}: holds an experiment already; name another folder, or add --overwrite'
                             for output in held)
    absent = [folder for output in chosen for folder in (output, *output.parents) if not folder.exists()]
    unused: list[Path] = []
    try:
        for output, parameters in chosen.items():
            unused.append(output)
            _prepare(output)
            save_configuration(output / 'parameters.yaml', parameters, robot)
        yield unused
    except (ParameterError, OSError):
        _restore(unused, absent)
        raise
    finally:
        for output in chosen:
            shutil.rmtree(output / _REPLACED, ignore_errors=True)


def _written(output: Path) -> list[Path]:
    """List the files of an experiment in a folder."""
    return [output / name for name in WRITTEN if (output / name).exists()]


def _remove(output: Path) -> None:
    for path in _written(output):
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def _prepare(output: Path) -> None:
    output.mkdir(parents=True, exist_ok=True)
    # of a killed run
    shutil.rmtree(output / _REPLACED, ignore_errors=True)
    (output / _REPLACED).mkdir()
    for path in _written(output):
        path.rename(output / _REPLACED / path.name)
    (output / 'log').mkdir()


def _restore(unused: list[Path], absent: list[Path]) -> None:
    for output in unused:
        replaced = list((output / _REPLACED).glob('*'))
        # it is empty if it could not be made
        if (output / _REPLACED).is_dir():
            _remove(output)
        for path in replaced:
            path.rename(output / path.name)
        with suppress(OSError):
            (output / _REPLACED).rmdir()
    for folder in absent:
        # a folder with other content stays
        with suppress(OSError):
            folder.rmdir()


def write_origin(output: Path, command_line: str, nodes: Mapping[str, Any], outcome: str = 'interrupted') -> None:
    """Write `metrics.json` of a run with nodes of somebody else before it is measured: a killed one has them, too."""
    content = {'outcome': outcome, 'duration': 0.0, 'provenance': {**provenance(command_line, None), 'nodes': nodes}}
    write_atomically(output / 'metrics.json', json.dumps(content, indent=2) + '\n')
