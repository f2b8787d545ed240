"""The closed loop of a configuration: its functions, its constants, and its state at t = 0."""

from mobile_robot_control.configuration.nodes import Configuration, has_exact_odometry
from mobile_robot_control.control.feedforward import lead
from mobile_robot_control.control.latency import NO_ODOMETRY
from mobile_robot_control.control.laws import select
from mobile_robot_control.control.velocity_pi import VelocityPiState
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.plant import TORQUE
from mobile_robot_control.model.plant_form import (
    Grid,
    drive_at_rest,
    drive_constants,
    plant_form,
    sensor_values,
    sensors_at_rest,
)
from mobile_robot_control.quantities import NO_ACCELERATION, BodyVelocity, Pose
from mobile_robot_control.simulation.closed_loop import Coming, Loop, LoopState
from mobile_robot_control.simulation.ticks import Form
from mobile_robot_control.stamps import period_nanoseconds


def form_of(configuration: Configuration) -> Form:
    """Return the choice of functions in the loop of a configuration."""
    shared = configuration.plant.shared
    return Form(plant_form(configuration.plant.model), configuration.position_controller.compensate_latency,
                shared.stamps_samples, shared.reference_horizon, shared.feedforward.enabled)


def plant_grid(configuration: Configuration) -> Grid:
    """Return the periods of the plant's grids in a configuration."""
    shared = configuration.plant.shared
    return Grid(period_nanoseconds(shared.velocity_rate), period_nanoseconds(shared.position_rate))


def start(configuration: Configuration) -> tuple[Loop, LoopState]:
    """Return the constants of the rollout of a checked configuration, and the state at t = 0, at rest."""
    shared, plant = configuration.plant.shared, configuration.plant
    law, gains = select(configuration.position_controller.control, 1.0 / shared.position_rate)
    model, grid, form = plant.model, plant_grid(configuration), form_of(configuration)
    feeds_torques = shared.feedforward.enabled and model.drive == TORQUE
    discrete = discretise(shared.robot, 1.0 / shared.velocity_rate, model.centripetal_coupling)
    loop = Loop(
        discrete,
        model.imperfections,
        model.max_wheel_torque,
        configuration.velocity_controller.max_wheel_torque,
        configuration.velocity_controller.gains,
        gains,
        configuration.position_controller.control.limits,
        configuration.reference_cart.curve.placement,
        1.0 / shared.position_rate,
        configuration.position_controller.odom_latency,
        shared.stamp_tolerance,
        drive_constants(model, discrete, grid),
        sensor_values(model, shared.robot, grid),
        lead(configuration.position_controller.control.feedforward),
        shared.robot if feeds_torques else (),
    )
    at_rest = dynamics.at_rest(Pose(*plant.initial_pose))
    return loop, LoopState(
        at_rest, VelocityPiState(), law.start, BodyVelocity(0.0, 0.0), drive_at_rest(model, grid),
        sensors_at_rest(at_rest, loop.sensors),
        NO_ODOMETRY if form.compensates and not form.timed else (),
        Coming(NO_ACCELERATION, 0) if feeds_torques else (),
    )


def shows_the_truth(configuration: Configuration) -> bool:
    """Return whether odometry is exact and reaches the law unchanged, so that its error is the true one."""
    controller = configuration.position_controller
    return has_exact_odometry(configuration.plant) and not (controller.compensate_latency and controller.odom_latency)
