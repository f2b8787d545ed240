"""Linear model predictive control of the tracking error within limits of the command, as a position law."""

import math
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control import BodyVelocity, Field, Law, NoState, Observation
from mpc_controller.error_model import Matrix, error_model


class MpcGains(NamedTuple):
    """Weights of the cost, horizon, and limits of the command."""

    longitudinal: Annotated[
        float, Field('1/m²', 'weight of the error ahead: larger closes the gap sooner and asks for more torque',
                     above=0.0, maximum=1e4, live=True, search=(0.0, 200.0))
    ] = 40.0
    lateral: Annotated[
        float, Field('1/m²', 'weight of the error aside: larger turns harder towards the path',
                     above=0.0, maximum=1e4, live=True, search=(0.0, 200.0))
    ] = 40.0
    heading: Annotated[
        float, Field('1/rad²', 'weight of the heading error: larger turns less across the path, and reaches it later',
                     above=0.0, maximum=1e4, live=True, search=(0.0, 10.0))
    ] = 1.0
    linear: Annotated[
        float, Field('s²/m²', 'weight of the velocity beside that of the reference: larger corrects more gently',
                     minimum=1e-3, maximum=1e4, live=True)
    ] = 1.0
    angular: Annotated[
        float, Field('s²/rad²', 'weight of the turn beside that of the reference: larger corrects more gently',
                     minimum=1e-3, maximum=1e4, live=True, search=(1e-3, 2.0))
    ] = 0.1
    stages: Annotated[int, Field('', 'stages of the horizon: more look further ahead and take longer to solve',
                                 minimum=1, maximum=20, live=True)] = 12
    period: Annotated[float, Field('s', 'of a stage: longer looks further ahead, and corrects later',
                                   minimum=0.01, maximum=0.2, live=True)] = 0.05
    max_linear: Annotated[float, Field('m/s', 'limit of |v|: larger catches up sooner, and asks for more torque',
                                       minimum=0.01, maximum=100.0, live=True)] = 1.0
    max_angular: Annotated[float, Field('rad/s', 'limit of |omega|: larger turns sooner, and asks for more torque',
                                        minimum=0.01, maximum=100.0, live=True)] = 3.0


class Prepared(NamedTuple):
    """
    What does not change from step to step.

    Attributes
    ----------
    stages : int
        N, of the horizon.
    period : float
        Of a stage [s].
    errors : array, shape (3 N,)
        Weights of all predicted errors.
    inputs : array, shape (2 N, 2 N)
        Weights of all inputs, on the diagonal.
    places : array of int, shape (N, N)
        How many stages before a predicted error an input is held; N where it comes later.
    limits : array, shape (2 N,)
        Of v [m/s] and omega [rad/s] in each stage.
    """

    stages: int
    period: float
    errors: Matrix
    inputs: Matrix
    places: NDArray[np.int_]
    limits: Matrix


@lru_cache(maxsize=1)
def _solver() -> Any:
    """Return the class of the solver, imported late: every node loads the record, and one with this law solves."""
    from piqp import DenseSolver  # noqa: PLC0415

    return DenseSolver


def prepare(gains: MpcGains, _dt: float) -> Prepared:
    """Return the matrices of the quadratic program that the reference does not change."""
    # a solver that is missing is told at the start
    _solver()
    count = gains.stages
    later = np.arange(count)[:, None] - np.arange(count)[None, :]
    return Prepared(
        count, gains.period,
        np.tile([gains.longitudinal, gains.lateral, gains.heading], count),
        np.diag(np.tile([gains.linear, gains.angular], count)),
        np.where(later < 0, count, later),
        np.tile([gains.max_linear, gains.max_angular], count),
    )


def _prediction(a: Matrix, b: Matrix, error: Matrix, prepared: Prepared) -> tuple[Matrix, Matrix]:
    """Return the errors without inputs, shape (3 N,), and what all inputs add to them, shape (3 N, 2 N)."""
    count = prepared.stages
    free = np.empty((count, 3))
    # A^k B, and nothing for an input that comes later
    effects = np.zeros((count + 1, 3, 2))
    for k in range(count):
        error = a @ error
        free[k], effects[k] = error, b
        b = a @ b
    return free.ravel(), effects[prepared.places].transpose(0, 2, 1, 3).reshape(3 * count, 2 * count)


def step(
    state: NoState, observation: Observation, prepared: Prepared, dt: float
) -> tuple[NoState, BodyVelocity]:
    """
    Return the first command of the sequence that minimises the predicted cost within the limits.

    The cost is the sum over N stages of e'Qe + u'Ru, with u = (v_r cos e3 - v, ω_r - ω) and e predicted by
    `error_model`, which is the linear model predictive control of G. Klancar and I. Skrjanc, "Tracking-error
    model-based predictive control for mobile robots in real time", Robotics and Autonomous Systems 55, 2007, with
    limits of v and ω as constraints in place of none. A law sees the present v_r and ω_r alone: both are held over the
    horizon.
    """
    e3 = observation.error.heading
    v_r, omega_r = observation.reference.velocity
    model = error_model(v_r, omega_r, prepared.period)
    free, effects = _prediction(*model, np.array(observation.error), prepared)
    # u'Hu/2 + c'u with H = G'QG + R and c = G'Q e_free
    weighted = effects * prepared.errors[:, None]
    hessian, slope = weighted.T @ effects + prepared.inputs, weighted.T @ free
    # v = v_r cos e3 - u1 at once, and v_r - u1 by the linear model of what is to come
    forward = np.tile([v_r, omega_r], prepared.stages)
    forward[0] = v_r * math.cos(e3)
    # a solver of its own for each step: one that is kept would remember the step before
    solver = _solver()()
    solver.setup(hessian, slope, x_l=forward - prepared.limits, x_u=forward + prepared.limits)
    solver.solve()
    command = forward[:2] - solver.result.x[:2]
    if not np.isfinite(command).all():
        # numbers too far apart for the solver, such as a weight of 1e4 at 1 km: drive as the reference does
        command = forward[:2]
    v, omega = np.clip(command, -prepared.limits[:2], prepared.limits[:2]).tolist()
    return state, BodyVelocity(v, omega)


LAW = Law('mpc', step, MpcGains, prepare=prepare)
