"""A run, simulated or read: topics, arrays on one time base, metrics and parameters."""

from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.runs.joining import Joined, join, moving_at
from mobile_robot_control.runs.record import RunRecord
from mobile_robot_control.runs.series import Gap, find_gaps
from mobile_robot_control.settings.law_sets import gains_of
from mobile_robot_control.system.texts import printable
from mobile_robot_control.topics import RUN_TOPICS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mobile_robot_control.settings.configure import File


_PAGES = 'mobile_robot_control.report.inline_page'
"""Imported by name on demand: pages are made of runs."""
_MOTION, _ERROR, _WHEELS = RUN_TOPICS['odom'].columns, RUN_TOPICS['tracking_error'].columns, ('right', 'left')
_POSE, _VELOCITY = _MOTION[:3], _MOTION[3:]
COLUMNS: dict[str, tuple[str, ...]] = {
    'pose': _POSE, 'velocity': _VELOCITY, 'reference': _POSE, 'reference_velocity': _VELOCITY, 'tracking_error': _ERROR,
    'cmd_vel': RUN_TOPICS['cmd_vel'].columns, 'wheel_velocity': _WHEELS, 'wheel_torque': _WHEELS, 'odometry': _POSE,
    'measured_error': _ERROR,
}
"""The columns of each array of a `Run`, in their order."""


class Run(RunRecord):
    """
    A run of the closed loop: its topics, arrays on one time base, metrics and parameters.

    The arrays have a row for each step of the velocity loop, with the values of its time. Between position ticks poses,
    velocities and `tracking_error` are interpolated, poses by cubics; commands and odometry are held, as on the topics.
    Unknown values, such as the torques of a base that takes velocity commands, are nan. The arrays are made on first
    use.

    Attributes
    ----------
    name : str
        For legends and tables.
    series : Series
        Its topics, each with its own stamps.
    problems : tuple of str
        Sentences about missing parts, or about an early end.
    metrics : dict of str to object
        As in `mrc simulate --json`; only measured ones.
    parameters : Configuration or None
        Of the run; None if not recorded.
    provenance : dict of str to object
        The call, versions and parameters that produced the run; for a run from a file, as recorded; {} if unknown.
    events : tuple of Event
        Changes during the run; only a bag contains them.

    Examples
    --------
    >>> from mobile_robot_control import simulate
    >>> run = simulate(duration=0.1)
    >>> run.tracking_error.shape, len(run.columns()), run.gaps
    ((51, 3), 26, {})

    """

    @cached_property
    def _joined(self) -> Joined:
        return join(self.series)

    @cached_property
    def _moving(self) -> dict[str, Floats]:
        return moving_at(self._joined)

    def _held(self, topic: str, *columns: str) -> Floats:
        return self._joined.values(topic)[:, [RUN_TOPICS[topic].columns.index(column) for column in columns]]

    @property
    def gaps(self) -> dict[str, list[Gap]]:
        """Silences of each topic that is not complete, by its name."""
        found = {topic: find_gaps(signal.stamps, self.series.origin) for topic, signal in self.series.signals.items()}
        return {topic: gaps for topic, gaps in found.items() if gaps}

    @property
    def time(self) -> Floats:
        """Times of the rows, from the start of the reference, shape (n,) [s]."""
        return self._joined.time

    @property
    def pose(self) -> Floats:
        """Pose of the robot: x, y [m] and heading in (-π, π] [rad], shape (n, 3); true if known beside odometry."""
        return self._moving['pose']

    @property
    def velocity(self) -> Floats:
        """Velocities v [m/s] and ω [rad/s] of the robot, shape (n, 2); true if `pose` is."""
        return self._moving['velocity']

    @property
    def reference(self) -> Floats:
        """Pose of the reference cart: x, y [m] and heading [rad], shape (n, 3)."""
        return self._moving['reference']

    @property
    def reference_velocity(self) -> Floats:
        """Velocities v_r [m/s] and ω_r [rad/s] of the cart, shape (n, 2)."""
        return self._moving['reference_velocity']

    @property
    def tracking_error(self) -> Floats:
        """Errors e1 ahead, e2 to the left [m] and e3 [rad] of `pose`, Eq. (23), shape (n, 3)."""
        return self._moving['tracking_error']

    @cached_property
    def cmd_vel(self) -> Floats:
        """Commands v [m/s] and ω [rad/s] of the position law, shape (n, 2)."""
        return self._held('cmd_vel', *_VELOCITY)

    @cached_property
    def wheel_velocity(self) -> Floats:
        """Velocities of the right and of the left wheel, as measured, shape (n, 2) [rad/s]."""
        return self._held('joint_states', 'right_velocity', 'left_velocity')

    @cached_property
    def wheel_torque(self) -> Floats:
        """Torques applied to the right and to the left wheel over the step that ends at `time`, shape (n, 2) [N m]."""
        return self._held('joint_states', 'right_effort', 'left_effort')

    @cached_property
    def odometry(self) -> Floats:
        """The pose in the position controller's odometry, shape (n, 3) [m], [rad]."""
        return self._held('odom', *_POSE)

    @cached_property
    def measured_error(self) -> Floats:
        """The error seen by the position law, that of `odometry`, shape (n, 3) [m], [rad]."""
        return self._held('tracking_error', *_ERROR)

    def __repr__(self) -> str:
        last = f', to t = {self.time[-1]:g} s' if self.time.size else ''
        rms = self.metrics.get('rms_position_error')
        error = '' if rms is None else f', RMS position error {rms:.4g} m'
        outcome = printable(str(self.metrics.get('outcome', 'not measured')))
        gains = '' if self.parameters is None else gains_of(self.parameters)
        name = printable(self.name) + (gains and f', {gains} gains')
        return f'<Run {name}: {self.time.size} samples{last}, {outcome}{error}>'

    def plot(self, figure: str = 'path', *others: 'Run') -> 'Figure':
        """
        Draw a figure of a report: of this run, or of several overlaid.

        Parameters
        ----------
        figure : str
            'path', 'position', 'heading', 'errors', 'distance', 'velocity', 'torque', 'power' or 'energy'.
        *others : Run
            Drawn over this one; up to five.

        Returns
        -------
        Figure
            Of Matplotlib; notebooks show it, and `savefig` writes it.

        Raises
        ------
        ParameterError
            If there is no figure of this name, nothing to draw in it, or too many runs.

        Examples
        --------
        >>> from mobile_robot_control import simulate
        >>> type(simulate(duration=0.1).plot('errors')).__name__
        'Figure'

        """
        # imported late: Matplotlib takes a second
        from mobile_robot_control.runs.plotting import plot  # noqa: PLC0415

        return plot(figure, [self, *others])

    def replay(self, *others: 'Run') -> Any:
        """
        Return the replay of a report, of this run or of several in step: an `InlinePage`, which notebooks show.

        Parameters
        ----------
        *others : Run
            Up to five.

        Raises
        ------
        ParameterError
            If there are too many.

        """
        return import_module(_PAGES).replay([self, *others])

    def report(self, folder: 'File', *others: 'Run', animation: bool = False) -> Any:
        """
        Write the report of the command `report`, and return its page, an `InlinePage`, which notebooks show.

        Parameters
        ----------
        folder : path
            For `report.html`, `report.json` and `figures`; existing ones are replaced.
        *others : Run
            Up to five, for comparison with this one.
        animation : bool
            Whether to animate each run.

        Raises
        ------
        ParameterError
            If there are too many.
        OSError
            If the files cannot be written.

        """
        return import_module(_PAGES).report([self, *others], Path(folder), animation)

    def columns(self) -> dict[str, Floats]:
        """Return time and every column of the arrays, each of shape (n,), by names such as 'pose.x'."""
        return {'time': self.time, **{
            f'{name}.{column}': getattr(self, name)[:, n]
            for name, columns in COLUMNS.items() for n, column in enumerate(columns)
        }}

    def save(self, file: 'File') -> None:
        """
        Write the table of the command `simulate`, for `load` and `report`.

        Numbers are written to the last bit. Parameters and metrics go beside the table, in FILE.parameters.yaml and
        FILE.metrics.json. Existing files are replaced.

        Parameters
        ----------
        file : path
            With the ending .csv.

        Raises
        ------
        ParameterError
            For another ending.
        OSError
            If the files cannot be written.

        """
        # imported late: it imports this module
        from mobile_robot_control.runs.run_files import save_run  # noqa: PLC0415

        save_run(self, file)

    def to_dataframe(self) -> Any:
        """
        Return all arrays as a table of pandas: time [s] is its index, `columns` are its columns.

        Raises
        ------
        ModuleNotFoundError
            If pandas is not installed.
        """
        columns = self.columns()
        time = columns.pop('time')
        table = as_dataframe(columns)
        table.index = time
        table.index.name = 'time'
        return table


def as_dataframe(columns: dict[str, Any]) -> Any:
    """Return a table of pandas; raise ModuleNotFoundError if that is not installed."""
    try:
        import pandas  # type: ignore[import-not-found,import-untyped,unused-ignore]  # noqa: PLC0415
    except ImportError as error:
        raise ModuleNotFoundError('to_dataframe needs pandas, which is not installed; install it with '
                                  "'pip install pandas', or take columns(), which has the same arrays",
                                  name='pandas') from error
    return pandas.DataFrame(columns)
