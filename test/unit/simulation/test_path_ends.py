"""What each law does where a path starts and ends, with a reference that stands."""

import math

from each import each_row

from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.configuration.nodes import course_of
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.simulation.rollout import recorded


@each_row('law', LAWS)
def test_a_law_starts_beside_the_path_and_stands_after_its_end(law, tmp_path):
    (tmp_path / 'path.csv').write_text('0,0\n1.5,0\n1.5,1\n')
    configuration = configure(load([], [
        ('/**.reference_horizon', 1), ('reference_cart.curve', 'path'),
        ('reference_cart.path.file', str(tmp_path / 'path.csv')), ('reference_cart.timing.max_linear_velocity', 0.5),
        ('reference_cart.timing.max_wheel_torque', 0.3), ('plant.initial_pose', [-0.1, 0.1, 0.3]),
        ('position_controller.controller_type', law)]))
    run, samples = recorded(configuration, course_of(configuration.reference_cart).period + 6.0)
    last = [*samples][-500:]
    assert run.outcome == 'completed'
    tick = last[-1].tick
    assert math.dist(tick.pose[:2], tick.reference.pose[:2]) < 0.02
    # near the cart its direction, which the fuzzy law turns to, says nothing: it goes on turning on the spot
    turning = 0.3 if law == 'fuzzy' else 0.02
    assert max(abs(sample.command.linear) for sample in last) < 0.01
    assert max(abs(sample.command.angular) for sample in last) < turning
    if law != 'fuzzy':
        assert abs(math.remainder(tick.pose.heading - tick.reference.pose.heading, 2.0 * math.pi)) < 0.03
