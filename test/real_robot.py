"""A covering array of what makes the simulated robot a real one: every pair of options is in one of these."""

BASE = {'plant.drive': 'velocity'}
LAGGING = {**BASE, 'plant.base.lag': [0.15, 0.1], 'plant.base.dead_time': [0.02, 0.043],
           'plant.base.max_acceleration': [1.0, 4.0]}
COARSE = {**BASE, 'plant.base.max_speed': [0.7, 2.0], 'plant.base.dead_zone': [0.01, 0.02],
          'plant.base.quantum': [0.001, 0.01], 'plant.base.command_rate': 30.0}
UNEVEN = {**BASE, 'plant.base.wheel_gain': [1.02, 0.98], 'plant.base.turn_gain': 0.9,
          'plant.base.max_deceleration': [2.0, 0.0]}
JITTER = {'plant.base.command_jitter': 0.012, 'plant.odometry.jitter': 0.015}
MOTORS = {'plant.motor.stall_torque': 2.0, 'plant.motor.no_load_speed': 30.0, 'plant.motor.time_constant': 0.01}
FRICTION = {'plant.friction.coulomb': 0.05}
LATE = {'plant.odometry.rate': 30.0, 'plant.odometry.latency': 0.05}
TICKS = {'plant.encoders.ticks': 2000, 'plant.encoders.window': 0.01}
DRIFTING = {'plant.odometry.dead_reckoning': True, 'plant.odometry.radius_error': [0.002, -0.001],
            'plant.odometry.separation_error': 0.01, 'plant.odometry.slip': 0.002}
NOISE = {'plant.noise.velocity': 0.01, 'plant.noise.pose': [0.001, 0.001, 0.002], 'plant.noise.seed': 3}
COMPENSATED = {'position_controller.compensate_latency': True, 'position_controller.odom_latency': 0.04}
DELAY = {'plant.delay.velocity_steps': 2}
STAMPED = {'/**.odometry_stamped': 'sampled'}
PUSHED = {'plant.disturbance.time': 0.5, 'plant.disturbance.impulse': [0.002, -0.001]}

ROBOTS = {
    'base with everything': {**LAGGING, **COARSE, **UNEVEN, **LATE, **JITTER, **TICKS, **DRIFTING, **NOISE,
                             **COMPENSATED},
    'torques with everything': {**MOTORS, **FRICTION, **LATE, **TICKS, **DRIFTING, **NOISE, **COMPENSATED, **DELAY,
                                **PUSHED, **STAMPED},
}
"""In `make test`."""
MORE = {
    'ideal base': BASE,
    'lagging, compensated, noise': {**LAGGING, **COMPENSATED, **NOISE},
    'lagging, late, drifting': {**LAGGING, **LATE, **DRIFTING},
    'coarse, ticks, noise': {**COARSE, **TICKS, **NOISE},
    'coarse, late, compensated': {**COARSE, **LATE, **COMPENSATED, **STAMPED},
    'uneven, jitter, compensated': {**UNEVEN, **LATE, **JITTER, **COMPENSATED, **STAMPED},
    'motors, ticks, compensated, pushed': {**MOTORS, **TICKS, **COMPENSATED, **PUSHED},
    'motors, late, noise': {**MOTORS, **LATE, **NOISE},
    'friction, drifting, delay': {**FRICTION, **DRIFTING, **DELAY},
    'friction, noise, pushed': {**FRICTION, **NOISE, **PUSHED},
    'motors, friction, coupled': {**MOTORS, **FRICTION, 'plant.centripetal_coupling': True},
    'hybrid law on a late base': {**LAGGING, **LATE, **COMPENSATED,
                                  'position_controller.controller_type': 'hybrid_backstepping'},
    'fuzzy law with friction': {**MOTORS, **FRICTION, **TICKS, 'position_controller.controller_type': 'fuzzy'},
}
"""In `make soak`."""


def assignments(options):
    """Return options as they are written after -p."""
    return [f'{name}:={str(value).lower() if isinstance(value, bool) else value}' for name, value in options.items()]
