"""What is measured on a run, and the chapter's objective."""

import math
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.quantities import Pose, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.simulation.closed_loop import Sample

_ERROR_WEIGHTS = (1.0, 5.0, 1.0)
_TORQUE_WEIGHTS = (1.0, 1.0)


class Totals(NamedTuple):
    """
    Sums and extremes over a run so far.

    Attributes
    ----------
    time : float
        Of the position ticks counted [s].
    squared_position, squared_heading : float
        ∫ e1² + e2² dt [m² s] and ∫ e3² dt [rad² s].
    max_position : float
        Largest distance to the reference [m].
    log_longitudinal, log_lateral, log_heading : float
        ∫ ln(1 + |e_i|) dt [s].
    peak_right, peak_left : float
        Largest absolute torque [N m].
    highest_right, highest_left : float
        Largest torque with its sign [N m].
    power_right, power_left : float
        Largest absolute power [W].
    energy : float
        ∫ of the positive power of both wheels [J].

    """

    time: float = 0.0
    squared_position: float = 0.0
    squared_heading: float = 0.0
    max_position: float = 0.0
    log_longitudinal: float = 0.0
    log_lateral: float = 0.0
    log_heading: float = 0.0
    peak_right: float = 0.0
    peak_left: float = 0.0
    highest_right: float = -math.inf
    highest_left: float = -math.inf
    power_right: float = 0.0
    power_left: float = 0.0
    energy: float = 0.0


@jitable
def add_error(totals: Totals, error: TrackingError, dt: float) -> Totals:
    """
    Count the tracking error of one position period, by the rectangle rule.

    Parameters
    ----------
    totals : Totals
        So far.
    error : TrackingError
        At the period's start.
    dt : float
        Position period [s].

    Returns
    -------
    Totals
        With this period.

    """
    squared = error.longitudinal * error.longitudinal + error.lateral * error.lateral
    return Totals(
        totals.time + dt,
        totals.squared_position + squared * dt,
        totals.squared_heading + error.heading * error.heading * dt,
        max(totals.max_position, math.sqrt(squared)),
        totals.log_longitudinal + math.log1p(abs(error.longitudinal)) * dt,
        totals.log_lateral + math.log1p(abs(error.lateral)) * dt,
        totals.log_heading + math.log1p(abs(error.heading)) * dt,
        totals.peak_right, totals.peak_left, totals.highest_right, totals.highest_left,
        totals.power_right, totals.power_left, totals.energy,
    )


@jitable
def add_torque(totals: Totals, torque: WheelTorque, wheels: WheelVelocity, dt: float) -> Totals:
    """
    Count the torque of one velocity period, by the rectangle rule.

    Parameters
    ----------
    totals : Totals
        So far.
    torque : WheelTorque
        Applied over the period [N m].
    wheels : WheelVelocity
        At the period's start [rad/s].
    dt : float
        Velocity period [s].

    Returns
    -------
    Totals
        With this period.

    """
    power_right, power_left = torque.right * wheels.right, torque.left * wheels.left
    return Totals(
        totals.time, totals.squared_position, totals.squared_heading, totals.max_position,
        totals.log_longitudinal, totals.log_lateral, totals.log_heading,
        max(totals.peak_right, abs(torque.right)),
        max(totals.peak_left, abs(torque.left)),
        max(totals.highest_right, torque.right),
        max(totals.highest_left, torque.left),
        max(totals.power_right, abs(power_right)),
        max(totals.power_left, abs(power_left)),
        totals.energy + (max(0.0, power_right) + max(0.0, power_left)) * dt,
    )


@jitable
def objective(totals: Totals, literal: bool) -> float:
    """
    Give the functional that the chapter's search minimises.

    Implements Eq. (29) of the chapter, with a1 = 1, a2 = 5, a3 = 1, a_R = a_L = 1.

    Parameters
    ----------
    totals : Totals
        Of a whole run.
    literal : bool
        True takes max τ as printed, which a search exploits with large negative torques; False takes max |τ|.

    Returns
    -------
    float
        F.

    """
    a1, a2, a3 = _ERROR_WEIGHTS
    a_right, a_left = _TORQUE_WEIGHTS
    # Eq. (29): F = Σ a_i ∫ ln(1 + |e_i|) dt + a_R max τ_R + a_L max τ_L
    return (
        a1 * totals.log_longitudinal + a2 * totals.log_lateral + a3 * totals.log_heading
        + a_right * (totals.highest_right if literal else totals.peak_right)
        + a_left * (totals.highest_left if literal else totals.peak_left)
    )


class Run(NamedTuple):
    """
    How a run went: what `metrics.json` says, before it is written.

    Attributes
    ----------
    outcome : str
        'completed', 'diverged', 'interrupted' or 'node_died'.
    duration : float
        [s].
    final_pose : Pose
        [m], [rad].
    initial_torque : WheelTorque
        Over the first step [N m].
    totals : Totals
        Sums and extremes.

    """

    outcome: str
    duration: float
    final_pose: Pose
    initial_torque: WheelTorque
    totals: Totals


class RunMeter:
    """
    Measures the samples of a run as they pass.

    Parameters
    ----------
    velocity_dt, position_dt : float
        Periods of the two loops [s].

    Attributes
    ----------
    totals : Totals
        Over the periods that have ended: [0, time of the last sample).
    initial_torque : WheelTorque
        Over the first step; zero before it has ended [N m].
    last : Sample or None
        The newest sample.

    """

    def __init__(self, velocity_dt: float, position_dt: float) -> None:
        self.totals = Totals()
        self.initial_torque = WheelTorque(0.0, 0.0)
        self.last: Sample | None = None
        self._velocity_dt, self._position_dt = velocity_dt, position_dt

    def add(self, sample: Sample) -> None:
        """
        Count the period that the sample ends.

        Parameters
        ----------
        sample : Sample
            The one after the last, one velocity period later.

        """
        last = self.last
        if last is not None:
            if last.time == 0.0:
                self.initial_torque = sample.applied
            self.totals = add_torque(self.totals, sample.applied, last.wheels, self._velocity_dt)
            if last.tick.time == last.time:
                self.totals = add_error(self.totals, last.tick.error, self._position_dt)
        self.last = sample

    def watch(self, samples: Iterable[Sample]) -> Iterator[Sample]:
        """
        Measure samples on their way to somebody else.

        Parameters
        ----------
        samples : iterable of Sample
            In order of time.

        Yields
        ------
        Sample
            The same.

        """
        for sample in samples:
            self.add(sample)
            yield sample

    def run(self, outcome: str) -> Run:
        """
        Sum up.

        Parameters
        ----------
        outcome : str
            'completed', 'diverged', 'interrupted' or 'node_died'.

        Returns
        -------
        Run
            Up to the last sample.

        Raises
        ------
        ValueError
            If there was no sample.

        """
        if self.last is None:
            raise ValueError('a run without a sample has no metrics')
        return Run(outcome, self.last.time, self.last.tick.pose, self.initial_torque, self.totals)


def summary(run: Run) -> dict[str, Any]:
    """
    Give the metrics by name, as `simulate --json` prints and `experiment` writes them.

    Parameters
    ----------
    run : Run
        Summed up.

    Returns
    -------
    dict of str to object
        SI units; what is not finite is None.

    """
    totals = run.totals
    mean = 1.0 / totals.time if totals.time > 0.0 else math.nan
    values = {
        'outcome': run.outcome,
        'duration': run.duration,
        'final_pose': list(run.final_pose),
        'rms_position_error': math.sqrt(totals.squared_position * mean),
        'max_position_error': totals.max_position,
        'rms_heading_error': math.sqrt(totals.squared_heading * mean),
        'initial_wheel_torque': run.initial_torque._asdict(),
        'peak_wheel_torque': {'right': totals.peak_right, 'left': totals.peak_left},
        'peak_wheel_power': {'right': totals.power_right, 'left': totals.power_left},
        'energy': totals.energy,
        'objective': objective(totals, False),
    }
    return {name: _finite(value) for name, value in values.items()}


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _finite(part) for name, part in value.items()}
    if isinstance(value, list):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
