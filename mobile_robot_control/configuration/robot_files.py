"""The parameter files of robots: those of this package by name, and those of users by path."""

import os
from functools import lru_cache
from pathlib import Path

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.values import nearest

_PACKAGE = Path(__file__).resolve().parents[1]
_ENDINGS = ('.yaml', '.yml')


def shipped_folder(name: str, package: Path = _PACKAGE) -> Path | None:
    """Return a folder of config/, in the repository or below the prefix of an installation; None if there is none."""
    places = [package.parent, *(prefix / 'share' / package.name for prefix in package.parents)]
    return next((folder for place in places if (folder := place / 'config' / name).is_dir()), None)


@lru_cache(maxsize=1)
def shipped_robots(package: Path = _PACKAGE) -> dict[str, Path]:
    """
    Return the robots of this package.

    Parameters
    ----------
    package : Path
        The folder of its modules.

    Returns
    -------
    dict of str to Path
        The parameter file by name; empty if the package is installed without its parameter files.

    """
    folder = shipped_folder('robots', package)
    return {file.stem: file for file in sorted(folder.glob('*.yaml'))} if folder else {}


def robot_file(robot: str) -> Path:
    """
    Return the parameter file of a robot.

    Parameters
    ----------
    robot : str
        A name of `shipped_robots`, or the path of a parameter file.

    Returns
    -------
    Path
        Not yet read.

    Raises
    ------
    ParameterError
        If it is neither; with the known names and the nearest.

    """
    shipped = shipped_robots()
    if robot in shipped:
        return shipped[robot]
    # os.path accepts any text
    if os.path.lexists(robot) or '/' in robot or robot.endswith(_ENDINGS):
        return Path(robot)
    if not shipped:
        raise ParameterError([f"--robot '{robot}': the package is installed without its robots; name a parameter file"])
    near = nearest(robot, shipped)
    known = '' if near.startswith('known are') else f'; known are {", ".join(shipped)}'
    raise ParameterError([f"--robot '{robot}': there is no robot of this name; {near}{known}; a file of your own is "
                          'named by its path, such as ./my_robot.yaml'])
