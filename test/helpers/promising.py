"""Plants of this package that are like the stand-in bases, and what is promised of them."""

import math

from helpers.harness import CONFIG
from helpers.stand_in_model import Base, drive
from mobile_robot_control.analysis.promises import promise, warnings_of
from mobile_robot_control.control.compensation import carried_forward, lead
from mobile_robot_control.control.laws import select
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.loop.batch import run_trials
from mobile_robot_control.loop.scenarios import configured_scenario
from mobile_robot_control.loop.trial import make_trial
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose
from mobile_robot_control.settings.configure import at_cart_start, configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import course_of

FROM, UNTIL = 10.0, 32.0
BASES = {
    'stand-in': Base(),
    'unlike wheels': Base(lag=0.3, unlike=0.05),
    'seldom, jitter, lost': Base(command_rate=10.0, odom_rate=15.0, jitter=0.02, lost=0.05),
    'slow to speed up, encoders': Base(acceleration=0.5, ticks=2000),
}
# found by tune for the plant like the first base: backstepping --seed 1 --generations 60 --population 60
# --curves trifolium lemniscate --start=0,0,0 --start=-0.2,0.1,0.3 --mass 0.5 1.2 --laps 2
TUNED = [f'position_controller.backstepping.{gain}' for gain in ('p:=4.99878', 'q:=0.237305', 'f:=2.51953',
                                                                 'g:=19.9902')]


FED = ['/**.feedforward.enabled:=true', '/**.reference_horizon:=1',
       'position_controller.feedforward.dead_time:=[0.025, 0.025]']
"""Half the period in which the base holds a command is dead time; the lag is that of the base."""


def fed(lag):
    return [*FED, f'position_controller.feedforward.lag:=[{lag}, {lag}]']


def model_of(base):
    """Return the parameters of the plant that model a base, by name, all of them."""
    return {
        'base.lag': [base.lag, base.lag], 'base.dead_time': [base.dead_time, base.dead_time],
        'base.command_rate': base.command_rate, 'base.dead_zone': [base.dead_zone, 0.0],
        'base.max_speed': [base.fastest, 0.0], 'base.command_jitter': base.jitter, 'odometry.jitter': base.jitter,
        'base.max_acceleration': [0.0 if math.isinf(base.acceleration) else base.acceleration, 0.0],
        'base.wheel_gain': [1.0 + 0.5 * base.unlike, 1.0 - 0.5 * base.unlike], 'base.turn_gain': base.turn,
        'odometry.rate': base.odom_rate, 'odometry.latency': base.latency,
        'encoders.ticks': base.ticks, 'encoders.window': 1.0 / base.odom_rate if base.ticks else 0.0,
        'odometry.dead_reckoning': base.ticks > 0, 'odometry.slip': 0.0,
    }


def plant_like(base, curve, given=(), lacking=()):
    """Return the parameters of a plant like a base, whose effects that it does not have are ruled out."""
    nothing = model_of(Base(command_rate=0.0, odom_rate=0.0, latency=0.0, lag=0.0, dead_zone=0.0, fastest=0.0))
    modelled = {name: value for name, value in model_of(base).items() if name not in lacking}
    absent = [name for name, value in modelled.items() if value == nothing[name]]
    options = [f'plant.{name}:={str(value).lower()}' for name, value in modelled.items()]
    stamps = 'position_controller.odom_latency:=0.06' if base.sent else '/**.odometry_stamped:=sampled'
    return at_cart_start(configure(load([CONFIG / 'wall_clock.yaml'], [
        'plant.drive:=velocity', *options, f'plant.ruled_out:={", ".join(absent)}', '/**.lockstep:=true', stamps,
        '/**.feedforward.enabled:=false', f'reference_cart.curve:={curve}', *given])))


def promised(parameters, since=FROM, until=UNTIL):
    trial = make_trial(parameters, until, late=since)
    late = run_trials([trial], False)[0].late
    return math.sqrt(late.squared_position / late.time)


def warned(parameters):
    """Return the warnings of a search that ends with these parameters."""
    return warnings_of(promise(parameters, [configured_scenario(parameters)]))


def driven(parameters, base, since=FROM, until=UNTIL, compensates=True):
    """Return the true RMS error [m] of a stand-in base, whose stamps the controller reads as on the wall clock."""
    course, shared = course_of(parameters.reference_cart), parameters.plant.shared
    dt = 1.0 / shared.position_rate
    law, gains = select(parameters.position_controller.control, dt)
    leads = [time / dt if shared.feedforward.enabled else 0.0
             for time in lead(parameters.position_controller.control.feedforward)]

    def control(time, stamp, pose, velocity):
        velocity = BodyVelocity(*velocity)
        age = time - stamp + parameters.position_controller.odom_latency if compensates else 0.0
        reference, following = (course.reference(at) for at in (time, time + dt))
        error = tracking_error(reference.pose, carried_forward(Pose(*pose), velocity, age))
        asked = law.step(law.start, Observation(error, reference, velocity), gains, dt)[1]
        # the lead, by differences of the reference's velocity
        return [v + ahead * (after - before) for v, before, after, ahead in zip(
            asked, reference.velocity, following.velocity, leads, strict=True)]

    truth = drive(base, control, course.reference(0.0).pose, until, 1.0 / dt)
    squares = [math.dist(course.reference(time).pose[:2], pose[:2])**2 for time, pose in truth if time >= since]
    return math.sqrt(sum(squares) / len(squares))
