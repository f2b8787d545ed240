"""A plant like the stand-in base of stand_in_model, and what is promised of it."""

import math

from harness import CONFIG

from mobile_robot_control.parameters.configuration import at_cart_start, configure
from mobile_robot_control.parameters.files import load
from mobile_robot_control.simulation.batch import run_trials
from mobile_robot_control.simulation.trial import make_trial

FROM, UNTIL = 10.0, 32.0
# the plant as the base is; its stamps tell the age of odometry
LIKE_THE_BASE = ['plant.drive:=velocity', 'plant.base.max_speed:=[0.7, 0.0]', 'plant.base.dead_zone:=[0.05, 0.0]',
                 'plant.base.command_rate:=20.0', 'plant.odometry.rate:=30.0', 'plant.odometry.latency:=0.06',
                 '/**.odometry_stamped:=sampled', '/**.lockstep:=true']
# found by tune for this plant at a lag of 0.15 s: backstepping --seed 1 --generations 60 --population 60
# --curves trifolium lemniscate --start=0,0,0 --start=-0.2,0.1,0.3 --mass 0.5 1.2 --laps 2
TUNED = [f'position_controller.backstepping.{gain}' for gain in ('p:=4.99878', 'q:=0.237305', 'f:=2.51953',
                                                                 'g:=19.9902')]


FED = ['/**.feedforward.enabled:=true', '/**.reference_horizon:=1', 'position_controller.feedforward.dead_time:=0.025']
"""Half the period in which the base holds a command is dead time; the lag is that of the base."""


def fed(lag):
    return [*FED, f'position_controller.feedforward.lag:={lag}']


def plant_like(lag, curve, gains):
    return at_cart_start(configure(load([CONFIG / 'wall_clock.yaml'], [
        *LIKE_THE_BASE, f'plant.base.lag:=[{lag}, {lag}]', f'reference_cart.curve:={curve}', *gains])))


def promised(parameters):
    trial = make_trial(parameters, UNTIL, late=FROM)
    late = run_trials([trial], False)[0].late
    return math.sqrt(late.squared_position / late.time)
