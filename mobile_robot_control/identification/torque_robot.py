"""The identification of a robot that takes wheel torques."""

from collections.abc import Callable, Sequence

import numpy as np

from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.identification import findings, torque_drive
from mobile_robot_control.identification.estimation import Estimate
from mobile_robot_control.identification.motors import fit_motors, motor_parameters
from mobile_robot_control.identification.recorded import Recorded
from mobile_robot_control.identification.result import (
    HELD_OUT,
    Identification,
    Parameter,
    Prediction,
    errors_of,
    interval_of,
    is_narrow,
    left_out,
    prediction_of,
    rates_of,
)
from mobile_robot_control.model.plant import TORQUE
from mobile_robot_control.model.robot import Robot, angular_inertia, linear_inertia


def identify_torques(
    recordings: Sequence[Recorded], configuration: Configuration, tell: Callable[[], object]
) -> Identification:
    """Identify mass, inertia and friction from efforts and wheel motion; motors from requested torques."""
    robot = configuration.plant.shared.robot
    usable = [one for one in recordings if one.torques and one.wheels]
    found, whole = torque_drive.fit_torques(usable, robot, tell)
    parameters = [interval_of(name, value, deviation, unit) for name, value, deviation, unit in zip(
        found.names, found.values.tolist(), found.deviations.tolist(), ('kg', 'kg m²', 'N m s/rad', 'N m'),
        strict=False)]
    kept = [one for one in parameters if is_narrow(one)]
    index = [found.names.index(one.name) for one in kept]
    motors = fit_motors(usable, tell)
    driven, motion = motor_parameters(motors) if motors else ([], [])
    start = dict(zip(found.names, found.values.tolist(), strict=True))
    split = float(np.mean([(1.0 - HELD_OUT) * np.ptp(one.wheels.times) + one.wheels.times[0]
                           for one in usable if one.wheels]))
    trained, _ = torque_drive.fit_torques(usable, robot, tell, split, start)
    values = dict(zip(trained.names, trained.values.tolist(), strict=True))
    moved = torque_drive.torque_model(whole, values, robot)
    predictions = [_torque_prediction(one, modelled, robot, split, name.name) for one, modelled, name in zip(
        whole, moved.outputs(moved.start), usable, strict=False)]
    notes = [f'wheel_inertia {robot.wheel_inertia} kg m², com_offset {robot.com_offset} m, radius '
             f'{robot.wheel_radius} m and separation {robot.wheel_separation} m are given: torques tell A + B and '
             'A - B, of which mass and inertia are made with these']
    wide = [left_out(one) for one in parameters if one not in kept]
    return Identification(
        TORQUE, (*kept, *driven), tuple(one.name for one in kept), found.covariance[np.ix_(index, index)],
        (*_combinations(found, robot), *motion), rates_of(usable[0].clocks), errors_of(predictions),
        (*wide, *(() if torque_drive.COULOMB in found.names else ('Coulomb friction: none shows beside the viscous '
                                                                  'one',))),
        tuple(findings.missing_in_model(found, predictions, [])), tuple(notes), tuple(predictions), found.whitened, {})


def _combinations(found: Estimate, robot: Robot) -> list[Parameter]:
    """Return A + B and A - B of Eq. (15), which the data determine, with their intervals."""
    def of(values: Floats) -> Floats:
        made, _ = torque_drive.robot_of(dict(zip(found.names, values.tolist(), strict=True)), robot)
        return np.array([linear_inertia(made), angular_inertia(made)])

    here = of(found.values)
    slopes = np.column_stack([
        (of(found.values + step) - here) / step.max() for step in np.diag(1e-6 * np.maximum(found.values, 1e-9))])
    deviations = np.sqrt(np.diag(slopes @ found.covariance @ slopes.T))
    return [interval_of(name, value, deviation, 'kg m²') for name, value, deviation in zip(
        ('A + B', 'A - B'), here.tolist(), deviations.tolist(), strict=True)]


def _torque_prediction(
    one: torque_drive.Known, modelled: Floats, robot: Robot, split: float, name: str
) -> Prediction:
    """Return the prediction of one recording; between its segments nothing is known."""
    rows = np.concatenate([np.arange(segment.first, segment.last) for segment in one.segments])
    moved = torque_drive.body_way(one.motion.moved, robot)
    filled = moved.copy()
    filled[rows] = modelled
    usable = np.zeros(moved.shape[0], bool)
    usable[rows] = True
    return prediction_of(name, one.motion.times, moved, filled, usable, split)
