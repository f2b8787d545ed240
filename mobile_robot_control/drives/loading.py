"""The reading of one run from Python, as the command `report` reads it."""

from collections.abc import Mapping

from mobile_robot_control.drives.judged_drive import FIRST, PathChoice, judged_drives
from mobile_robot_control.drives.page import as_values
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.parameters.requests import make_request
from mobile_robot_control.runs.reading import load_run
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_files import UnreadableRunError, name_of
from mobile_robot_control.settings.configure import File


def load(
    path: File, name: str | None = None, namespace: str = '/', topics: Mapping[str, str] | None = None,
    progress: bool = False, by_path: File | None = None, plan: str = FIRST,
) -> Run:
    """
    Read a recorded run, as the command `report` does.

    Parameters
    ----------
    path : path
        A bag (mcap or sqlite3), the folder of an experiment, or a CSV file of `simulate`.
    name : str or None
        For legends; if None, that of the file or of the folder.
    namespace : str
        Of the nodes of a bag.
    topics : mapping of str to str or None
        Names of topics of the loop in a bag, such as ``{'odom': '/base/odom'}``.
    progress : bool
        Whether to show a progress bar.
    by_path : path or None
        Topic of plans in the bag, file of waypoints or ``'reference'``: the drive is judged by that path, into
        ``metrics['path']``, a row for each goal and each kind of poses; see docs/metrics.md.
    plan : str
        ``'first'`` or ``'newest'`` of several plans for one goal.

    Returns
    -------
    Run
        As from `simulate`; ``problems`` names everything that could not be read.

    Raises
    ------
    ParameterError
        If there is no run at this path; it says what to name instead.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import mkdtemp
    >>> from mobile_robot_control import simulate
    >>> file = Path(mkdtemp(), 'run.csv')
    >>> simulate(duration=0.1).save(file)
    >>> load(file).time.shape
    (51,)

    """
    named, place = name_of(str(path))
    try:
        run = load_run(named if name is None else name, place, namespace, quiet=not progress, topics=topics,
                       timed=by_path is None)
        if by_path is None:
            return run
        choice = make_request(PathChoice, {'path': str(by_path), 'plan': plan})
        drives, notes = judged_drives(run, place, choice, namespace, topics or {})
        return run._replace(metrics={**run.metrics, 'path': as_values(drives)}, problems=(*run.problems, *notes))
    except UnreadableRunError as error:
        raise ParameterError([str(error)]) from error
