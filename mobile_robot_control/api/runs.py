"""A run as arrays on one time base, whether it was simulated or read."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.values import nearest
from mobile_robot_control.reporting.lines import Floats
from mobile_robot_control.reporting.series import Series
from mobile_robot_control.system.texts import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mobile_robot_control.configuration.sources import File

_POSE, _VELOCITY, _WHEELS = ('x', 'y', 'heading'), ('linear', 'angular'), ('right', 'left')
_ERROR = ('longitudinal', 'lateral', 'heading')
COLUMNS: dict[str, tuple[str, ...]] = {
    'pose': _POSE, 'velocity': _VELOCITY, 'reference': _POSE, 'reference_velocity': _VELOCITY, 'tracking_error': _ERROR,
    'cmd_vel': _VELOCITY, 'wheel_velocity': _WHEELS, 'wheel_torque': _WHEELS, 'odometry': _POSE,
    'measured_error': _ERROR,
}
"""The columns of each array of a `Run`, in their order."""


class Run(NamedTuple):
    """
    A run of the closed loop: arrays on one time base, metrics and parameters.

    There is a row for each step of the velocity loop, with the values of its time. Between position ticks poses,
    velocities and `tracking_error` are interpolated, poses by cubics; commands and what odometry showed are held, as on
    the topics. What is not known, such as the torques of a base that takes velocity commands, is nan.

    Attributes
    ----------
    name : str
        For legends and tables.
    time : array of float, shape (n,)
        From the start of the reference [s].
    pose : array of float, shape (n, 3)
        x, y [m] and heading in (-π, π] [rad] of the robot: the true ones where they are known beside odometry.
    velocity : array of float, shape (n, 2)
        v [m/s] and ω [rad/s] of the robot, true as `pose` is.
    reference : array of float, shape (n, 3)
        x, y [m] and heading [rad] of the reference cart.
    reference_velocity : array of float, shape (n, 2)
        v_r [m/s] and ω_r [rad/s] of the cart.
    tracking_error : array of float, shape (n, 3)
        e1 ahead, e2 to the left [m] and e3 [rad], Eq. (23), of `pose`.
    cmd_vel : array of float, shape (n, 2)
        v [m/s] and ω [rad/s] that the position law commands.
    wheel_velocity : array of float, shape (n, 2)
        Of the right and of the left wheel [rad/s], as measured.
    wheel_torque : array of float, shape (n, 2)
        Applied to the right and to the left wheel over the step that ends at `time` [N m].
    odometry : array of float, shape (n, 3)
        The pose that the position controller received [m], [rad].
    measured_error : array of float, shape (n, 3)
        The error that the position law took, that of `odometry` [m], [rad].
    metrics : dict of str to object
        As `simulate --json` prints them.
    parameters : Configuration or None
        Of the run; None where they were not recorded.
    problems : tuple of str
        Sentences about what is missing, or why the run did not reach its end.
    series : Series
        Its topics, each with its own stamps.
    provenance : dict of str to object
        Call, versions and parameters that it was made with; of a run that was read, as it was recorded; {} where
        nothing is known.
    """

    name: str
    time: Floats
    pose: Floats
    velocity: Floats
    reference: Floats
    reference_velocity: Floats
    tracking_error: Floats
    cmd_vel: Floats
    wheel_velocity: Floats
    wheel_torque: Floats
    odometry: Floats
    measured_error: Floats
    metrics: dict[str, Any]
    parameters: Configuration | None
    problems: tuple[str, ...]
    series: Series
    provenance: dict[str, Any] = {}  # noqa: RUF012 (never changed)

    def __repr__(self) -> str:
        last = f', to t = {self.time[-1]:g} s' if self.time.size else ''
        rms = self.metrics.get('rms_position_error')
        error = '' if rms is None else f', RMS position error {rms:.4g} m'
        outcome = printable(str(self.metrics.get('outcome', 'not measured')))
        return f'<Run {printable(self.name)}: {self.time.size} samples{last}, {outcome}{error}>'

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

        """
        # imported late: Matplotlib takes a second
        from mobile_robot_control.api.figures import draw  # noqa: PLC0415

        return draw(figure, [self, *others])

    def columns(self) -> dict[str, Floats]:
        """Return time and every column of the arrays, each of shape (n,), by names such as 'pose.x'."""
        return {'time': self.time, **{
            f'{name}.{column}': getattr(self, name)[:, n]
            for name, columns in COLUMNS.items() for n, column in enumerate(columns)
        }}

    def save(self, file: 'File') -> None:
        """
        Write the table of the command `simulate`, which `load` and `report` take.

        Numbers are written to the last bit. The parameters and the metrics go beside it, in FILE.parameters.yaml and
        FILE.metrics.json. Files that are there are replaced.

        Parameters
        ----------
        file : path
            Ends in .csv.

        Raises
        ------
        ParameterError
            If it has another ending.
        OSError
            If it cannot be written.

        """
        # imported late: commands read runs, too
        from mobile_robot_control.api.saving import save_run  # noqa: PLC0415

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
    """Return a table of pandas; raise ModuleNotFoundError where that is not installed."""
    try:
        import pandas  # type: ignore[import-not-found,import-untyped,unused-ignore]  # noqa: PLC0415
    except ImportError as error:
        raise ModuleNotFoundError('to_dataframe needs pandas, which is not installed; install it with '
                                  "'pip install pandas', or take columns(), which has the same arrays",
                                  name='pandas') from error
    return pandas.DataFrame(columns)


def unknown_figure(name: str, known: Iterable[str]) -> ParameterError:
    """Return the error of a figure that does not exist."""
    return ParameterError([f"figure = '{printable(str(name))}': there is no such figure; {nearest(str(name), known)}"])
