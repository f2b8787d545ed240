"""The track of Klancar et al., chapter 3: its linear law, and three more against the equations of the book."""

import csv
import json
import math
from pathlib import Path

import pytest
from helpers.harness import run_command

from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure, rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

KLANCAR = Path(__file__).parents[1] / 'plugins' / 'klancar.py'
PERIOD, STEPS = 0.033, 910
ZETA, G = 0.9, 85.0
TRACK = ['plant.drive:=velocity', f'/**.velocity_rate:={1.0 / PERIOD!r}', f'/**.position_rate:={1.0 / PERIOD!r}',
         'plant.initial_pose:=[1.1, 0.8, 0.0]', 'reference_cart.curve:=lissajous', 'reference_cart.scale:=0.7',
         'reference_cart.center:=[1.1, 0.9]', 'reference_cart.period:=30.0']


def cart(t):
    """Return the position and velocity of the cart, and its speed and angular velocity."""
    w = 2.0 * math.pi / 30.0
    x, y = 1.1 + 0.7 * math.sin(w * t), 0.9 + 0.7 * math.sin(2.0 * w * t)
    dx, dy = 0.7 * w * math.cos(w * t), 1.4 * w * math.cos(2.0 * w * t)
    ddx, ddy = -0.7 * w**2 * math.sin(w * t), -2.8 * w**2 * math.sin(2.0 * w * t)
    v_r, w_r = math.hypot(dx, dy), (dx * ddy - dy * ddx) / (dx**2 + dy**2)
    return x, y, dx, dy, v_r, w_r


def listing(heading_feedback):
    """Return the position errors of the book's listing, whose robot moves along the exact arc."""
    q, apart = [1.1, 0.8, 0.0], []
    for k in range(STEPS):
        x, y, dx, dy, v_r, w_r = cart(k * PERIOD)
        e_x = math.cos(q[2]) * (x - q[0]) + math.sin(q[2]) * (y - q[1])
        e_y = -math.sin(q[2]) * (x - q[0]) + math.cos(q[2]) * (y - q[1])
        e_phi = math.remainder(math.atan2(dy, dx) - q[2], 2.0 * math.pi)
        k_x = 2.0 * ZETA * math.sqrt(w_r**2 + G * v_r**2)
        v = v_r * math.cos(e_phi) + k_x * e_x
        omega = w_r + heading_feedback(v_r, e_y, e_phi, k_x)
        apart.append(math.hypot(x - q[0], y - q[1]))
        turned = q[2] + omega * PERIOD
        q = [q[0] + v / omega * (math.sin(turned) - math.sin(q[2])),
             q[1] - v / omega * (math.cos(turned) - math.cos(q[2])), turned]
    return apart


def measures(apart):
    """Return RMS, IAE, ISE, ITAE and ITSE by the rectangle rule."""
    squared = sum(a * a for a in apart)
    timed = [k * PERIOD * a for k, a in enumerate(apart)]
    return {
        'rms_position_error': math.sqrt(squared / len(apart)), 'iae': PERIOD * sum(apart), 'ise': PERIOD * squared,
        'itae': PERIOD * sum(timed), 'itse': PERIOD * sum(t * a for t, a in zip(timed, apart, strict=True)),
    }


def compensator_listing():
    """
    Return the position errors of the book's listing of dynamic feedback, from (1.15, 0.8), with k_p = 5 and k_d = 4.

    As it is printed but for three things, each of which the law does as its page says: it begins with the speed of the
    cart along the robot, the compensator decays exactly, and the cart's acceleration along its way is a difference.
    """
    kp, kd = 5.0, 4.0
    q, apart, xi, last = [1.15, 0.8, 0.0], [], None, None
    for k in range(STEPS):
        x, y, dx, dy, v_r, w_r = cart(k * PERIOD)
        xi, rate = (v_r, 0.0) if last is None else (xi, (v_r - last) / PERIOD)
        last = v_r
        phi = math.atan2(dy, dx)
        ax, ay = (rate * math.cos(phi) - v_r * w_r * math.sin(phi), rate * math.sin(phi) + v_r * w_r * math.cos(phi))
        ux = ax + kp * (x - q[0]) + kd * (dx - xi * math.cos(q[2]))
        uy = ay + kp * (y - q[1]) + kd * (dy - xi * math.sin(q[2]))
        apart.append(math.hypot(x - q[0], y - q[1]))
        # vv = F \\ uu with the speed before the integration; then u = [v; vv(2)] with the one after it
        omega = (uy * math.cos(q[2]) - ux * math.sin(q[2])) / xi
        xi += (ux * math.cos(q[2]) + uy * math.sin(q[2])) * (-math.expm1(-kd * PERIOD) / kd)
        turned = q[2] + omega * PERIOD
        q = [q[0] + xi / omega * (math.sin(turned) - math.sin(q[2])),
             q[1] - xi / omega * (math.cos(turned) - math.cos(q[2])), turned]
    return apart


def test_dynamic_feedback_commands_the_speed_that_the_listing_commands():
    law = 'dynamic_feedback_linearization'
    run = configure(load([], [*TRACK, f'position_controller.controller_type:={law}',
                              f'position_controller.{law}.kp:=5.0', f'position_controller.{law}.kd:=4.0',
                              'plant.initial_pose:=[1.15, 0.8, 0.0]']))
    apart = [math.hypot(*sample.tick.error[:2]) for sample in rollout(run, STEPS * PERIOD)][:STEPS]
    assert apart == pytest.approx(compensator_listing(), abs=1e-9)
    # the number of docs/base.md
    assert measures(apart)['rms_position_error'] == pytest.approx(23.436e-3, rel=5e-5)


@pytest.mark.parametrize(('law', 'gain', 'heading_feedback', 'printed'), [
    ('ramsete', 'b', lambda v, e_y, e_phi, k: G * v * math.sin(e_phi) / e_phi * e_y + k * e_phi,
     (12.671e-3, 0.079316, 4.8217e-3)),
    ('periodic', 'g', lambda v, e_y, e_phi, k: G * v * math.cos(e_phi / 2.0)**4 * e_y + k * math.sin(e_phi),
     (13.443e-3, 0.084477, 5.4272e-3)),
])
def test_the_published_track_has_the_errors_of_the_listing(law, gain, heading_feedback, printed):
    run = configure(load([], [*TRACK, f'position_controller.controller_type:={law}',
                              f'position_controller.{law}.zeta:={ZETA}', f'position_controller.{law}.{gain}:={G}']))
    apart = [math.hypot(*sample.tick.error[:2]) for sample in rollout(run, STEPS * PERIOD)][:STEPS]
    apart_in_the_listing = listing(heading_feedback)
    assert apart == pytest.approx(apart_in_the_listing, abs=1e-9)
    expected, metrics = measures(apart_in_the_listing), summary(measure(run, STEPS * PERIOD))
    assert {name: metrics[name] for name in expected} == pytest.approx(expected, rel=1e-9)
    # the numbers of docs/base.md
    assert [metrics[name] for name in ('rms_position_error', 'iae', 'ise')] == pytest.approx(printed, rel=5e-5)
    assert metrics['torque_variation'] is None


def test_klancars_linear_law_on_the_published_track(tmp_path):
    # the book's listing, moved along the exact arc: 12.469 mm, 0.077823 m s and 113.66 mm
    table = tmp_path / 'track.csv'
    done = run_command('simulate', '--law', KLANCAR, '--duration', 30.03, '--json', '--output', table, *(
        word for given in (*TRACK, 'position_controller.controller_type:=klancar') for word in ('-p', given)))
    assert done.returncode == 0, done.stderr
    metrics = json.loads(done.stdout)
    assert metrics['rms_position_error'] == pytest.approx(12.469e-3, abs=5e-7)
    assert metrics['max_position_error'] == pytest.approx(113.66e-3, abs=5e-6)
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 911
    apart = [math.hypot(float(row['tracking_error.vector.x']), float(row['tracking_error.vector.y']))
             for row in rows[:-1]]
    assert 0.033 * sum(apart) == pytest.approx(0.077823, abs=5e-7)
    # there is no torque
    assert metrics['peak_wheel_torque'] is metrics['energy'] is None
    assert {row[name] for row in rows for name in row if 'effort' in name} == {''}
