"""The timing of a path by toppra, to compare with ours: without friction, with its interpolation scheme."""

import numpy as np

from mobile_robot_control.model.robot import angular_inertia, half_separation, linear_inertia


class Oracle:
    """The path of a grid, with limits of v, of both accelerations and of the torque of a robot without friction."""

    def __init__(self, toppra, grid, timing, robot):
        self._grid = grid
        self._lengths = lengths = np.concatenate([[0.0], np.cumsum(grid.length)])
        curvature, sharpness = (np.append(each[:, 0], each[-1, 1]) for each in (grid.curvature, grid.sharpness))
        heading = np.concatenate([[0.0], np.cumsum(grid.curvature.mean(axis=1) * grid.length)])

        class AlongAndAround(toppra.interpolator.AbstractGeometricPath):
            """Length and heading of the path."""

            def __call__(self, at, order=0):
                at = np.asarray(at)
                ones = np.ones_like(at)
                return np.stack([(at, ones, 0.0 * ones)[order],
                                 np.interp(at, lengths, (heading, curvature, sharpness)[order])], axis=-1)

            dof, path_interval, waypoints = 2, np.array([0.0, lengths[-1]]), (lengths, np.zeros((2, 2)))

        interpolated = {'discretization_scheme': toppra.constraint.DiscretizationType.Interpolation}
        r, half = robot.wheel_radius, half_separation(robot)
        inverse = np.array([[linear_inertia(robot), half * angular_inertia(robot)],
                            [linear_inertia(robot), -half * angular_inertia(robot)]]) / r
        torque = timing.torque_fraction * timing.max_wheel_torque
        fastest, hardest, sharpest = (
            timing.max_linear_velocity, timing.max_linear_acceleration, timing.max_angular_acceleration)
        limits = [
            toppra.constraint.JointVelocityConstraint(np.array([[-fastest, fastest], [-1e6, 1e6]])),
            toppra.constraint.JointAccelerationConstraint(
                np.array([[-hardest, hardest], [-sharpest, sharpest]]), **interpolated),
            toppra.constraint.SecondOrderConstraint.joint_torque_constraint(
                lambda _q, _dq, ddq: inverse @ ddq, np.array([[-torque, torque]] * 2), np.zeros(2), **interpolated),
        ]
        self._algorithm = toppra.algorithm.TOPPRA(limits, AlongAndAround(), gridpoints=lengths, solver_wrapper='seidel')

    def duration(self):
        """Return the duration of the fastest motion from rest to rest [s]."""
        _, speeds, _ = self._algorithm.compute_parameterization(0.0, 0.0)
        return float(np.sum(2.0 * self._grid.length / (speeds[1:] + speeds[:-1])))
