"""All metrics in one table: name, label, unit, definition, and which way is better."""

from typing import NamedTuple

BAND = 0.02
"""[m]: default width of the band for a settled error."""


class Metric(NamedTuple):
    """
    A metric of a run.

    Attributes
    ----------
    name : str
        Name in files.
    unit : str
        SI unit; '' for a pure number or a text.
    definition : str
        In Markdown, as docs/metrics.md has it.
    label : str
        On pages, with ``{band}`` for the band of a settled error [m]; '' for a metric without a row there.
    better : str
        The better direction: 'smaller' or 'larger'; '' if metrics are not compared by it.
    of_wheels : bool
        Whether it has a value for each wheel, 'right' and 'left'.
    needs : tuple of str
        Properties that runs must share to be compared by it: the same `error`, and `energy` known or unknown.

    """

    name: str
    unit: str
    definition: str
    label: str = ''
    better: str = ''
    of_wheels: bool = False
    needs: tuple[str, ...] = ()

    def label_in(self, band: float = BAND) -> str:
        """Return its label for a band of a settled error [m]."""
        return self.label.format(band=f'{band:g}')


_ERROR = ('error',)
RUN_METRICS = (
    Metric('outcome', '', '`completed`: the run reached its duration. `diverged`: a velocity, or the distance from '
           'the start along x or y, became larger than 1e6 or not finite. `law_failed`: the position law raised, or '
           'its command was not finite; what was measured up to then is kept. `interrupted`: stopped by Ctrl-C, or '
           'nothing more could be recorded. `node_died`: a node ended, or gave no answer for `--patience`'),
    Metric('duration', 's', 'S, the simulated time that was measured; shorter than asked for where the outcome is not '
           '`completed`'),
    Metric('final_pose', 'm, m, rad', '[x, y, yaw] at the last position tick, of the pose that `error` names'),
    Metric('error', '', 'the pose behind the errors: `true` or `measured`, as [below](#true-and-measured-errors)'),
    Metric('rms_position_error', 'm', '√(Σ (e1² + e2²) / N)', 'position error, RMS', 'smaller', needs=_ERROR),
    Metric('max_position_error', 'm', 'max √(e1² + e2²)', 'position error, largest', 'smaller', needs=_ERROR),
    Metric('rms_heading_error', 'rad', '√(Σ e3² / N), e3 wrapped into (-π, π]', 'heading error, RMS', 'smaller',
           needs=_ERROR),
    Metric('measured_rms_position_error', 'm', 'as `rms_position_error`, of the error that the position controller '
           'saw; equal to it where odometry is exact'),
    Metric('initial_wheel_torque', 'N m', '{right, left}: τ over the first velocity step, with its sign',
           'first torque', of_wheels=True),
    Metric('peak_wheel_torque', 'N m', r'{right, left}: max \|τ\|', 'peak torque', 'smaller', of_wheels=True),
    Metric('peak_wheel_power', 'W', r'{right, left}: max \|τ ω\|', 'peak power', 'smaller', of_wheels=True),
    Metric('energy', 'J', 'Σ (max(0, τ_R ω_R) + max(0, τ_L ω_L)) T_v: energy from the motors; braking returns none',
           'energy', 'smaller'),
    Metric('objective', '', r'Eq. (29): Σ (ln(1 + \|e1\|) + 5 ln(1 + \|e2\|) + ln(1 + \|e3\|)) T_p + max \|τ_R\| + max '
           r'\|τ_L\|. The chapter takes max τ ([deviation 7](equations.md#deviations-from-the-chapter))',
           'objective, Eq. (29)', 'smaller', needs=('error', 'energy')),
)
"""Metrics in `metrics.json`, in its order, before the performance indices."""
INDEX_METRICS = (
    Metric('iae', 'm s', '∫ d dt: Σ d T_p', 'position error, ∫ d dt (IAE)', 'smaller', needs=_ERROR),
    Metric('ise', 'm² s', '∫ d² dt: Σ d² T_p', 'position error, ∫ d² dt (ISE)', 'smaller', needs=_ERROR),
    Metric('itae', 'm s²', '∫ t d dt: Σ t_n d T_p, with t_n from the start of the lap at t = 0',
           'position error, ∫ t d dt (ITAE)', 'smaller', needs=_ERROR),
    Metric('itse', 'm² s²', '∫ t d² dt: Σ t_n d² T_p', 'position error, ∫ t d² dt (ITSE)', 'smaller', needs=_ERROR),
    Metric('rms_cross_track_error', 'm', '√(Σ c² / N) of the [cross-track error](#cross-track-error) c',
           'cross-track error, RMS', 'smaller', needs=_ERROR),
    Metric('max_cross_track_error', 'm', 'max c', 'cross-track error, largest', 'smaller', needs=_ERROR),
    Metric('settling_time', 's', 'first tick from which d ≤ 0.02 m at all ticks up to S: 0 if d was never larger, '
           'null if it is larger at the last tick', 'settling time, to {band} m', 'smaller', needs=_ERROR),
    Metric('share_within_band', '', 'share of the ticks at which d ≤ 0.02 m', 'share of time within {band} m',
           'larger', needs=_ERROR),
    Metric('torque_variation', 'N m', r'Σ \|Δτ_R\| + \|Δτ_L\| over the velocity steps, from rest',
           'variation of the torque', 'smaller'),
    Metric('command_variation', 'm/s', r'Σ \|Δ(v + R ω)\| + \|Δ(v - R ω)\| of the commands, from rest: the changes of '
           "the speeds of both wheels' rims that they ask for, with R half the wheel separation",
           'variation of the command', 'smaller'),
)
"""The performance indices, in the order of files."""
LATE = Metric('late_max_position_error', 'm', 'max √(e1² + e2²) over the position ticks of the last quarter',
              'position error, largest in the last quarter', 'smaller')
"""Only of studies: their criterion of success."""
METRIC_TABLE = {metric.name: metric for metric in (*RUN_METRICS, *INDEX_METRICS, LATE)}
"""All metrics by name."""
INDICES = tuple(metric.name for metric in INDEX_METRICS)
"""The names of the performance indices."""
