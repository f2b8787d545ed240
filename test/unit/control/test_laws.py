"""The position laws by name: selected, changed without a jump of the command, limited, and a new one added."""

import ast
import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.observation import observed

import mobile_robot_control
from mobile_robot_control.control import fuzzy, hybrid_backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.bumpless_transfer import begin, change, step
from mobile_robot_control.control.compensation import Feedforward
from mobile_robot_control.control.hybrid_backstepping import TRACKING, HybridState
from mobile_robot_control.control.laws import BUILT_IN, LAWS, RESERVED, PositionControl, law_violations, select
from mobile_robot_control.control.limits import Limits, limit_command
from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose, Reference, TrackingError
from mobile_robot_control.settings.files import is_ros_parameter
from mobile_robot_control.settings.nodes import PositionControllerParameters

DT = 0.05
BRISK = PositionControl(backstepping=BacksteppingGains(p=2.0, q=1.0, f=4.0, g=3.0))
GENTLE = PositionControl(backstepping=BacksteppingGains(p=1.0, q=1.0, f=1.0, g=1.0))
HYBRID = GENTLE._replace(controller_type='hybrid_backstepping')


def seen(error, velocity):
    return observed(TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity)))


SEEN = seen((0.2, 0.1, -0.3), (0.5, 0.2))
ON_THE_CART = seen((0.0, 0.0, 0.0), (0.5, 0.2))


@pytest.mark.parametrize(('parameters', 'function', 'gains'), [
    (HYBRID, hybrid_backstepping.step, (GENTLE.backstepping, GENTLE.hybrid_backstepping)),
    (GENTLE._replace(controller_type='fuzzy'), fuzzy.step, GENTLE.fuzzy),
])
def test_select_gives_the_law_with_its_gains(parameters, function, gains):
    law, selected = select(parameters, 0.01)
    assert (law.step, selected) == (function, gains)


def test_the_names_that_no_law_may_have_are_those_of_the_node():
    first_words = {name.partition('.')[0] for name in declarations(PositionControllerParameters)} - set(LAWS)
    assert first_words <= RESERVED
    assert not any(is_ros_parameter(name) for name in LAWS)


def test_parameters_are_equal_where_all_of_them_are():
    assert GENTLE == GENTLE._replace() != HYBRID
    assert GENTLE.backstepping != GENTLE


@pytest.mark.parametrize('horizon', [-1, 1.5])
def test_a_law_whose_horizon_is_no_number_of_ticks_is_refused(horizon):
    refusal, = law_violations(LAWS['fuzzy']._replace(horizon=horizon))
    assert refusal == f"'fuzzy': its horizon is {horizon}; write the number of position ticks ahead"


def test_new_gains_do_not_jump_and_the_difference_decays_in_a_fifth_of_a_second():
    running, before = step(begin(GENTLE, DT, under_way=False), SEEN, DT)
    running = change(running, BRISK, DT)
    _, new = step(begin(BRISK, DT, under_way=False), SEEN, DT)
    assert new != pytest.approx(before, rel=1e-3)
    for k in range(40):
        running, command = step(running, SEEN, DT)
        # law + (last before - first after) exp(-t / 0.2 s)
        fade = math.exp(-k * DT / 0.2)
        expected = tuple(after + (last - after) * fade for last, after in zip(before, new, strict=True))
        assert command == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(('under_way', 'state'), [(False, HybridState()), (True, TRACKING)])
def test_a_hybrid_law_seeks_the_cart_only_at_the_start_of_a_run_and_keeps_its_state_under_new_gains(under_way, state):
    running = begin(HYBRID, DT, under_way)
    assert running.state.law == state
    running, _ = step(running, SEEN, DT)
    changed = change(running, HYBRID._replace(backstepping=BRISK.backstepping), DT)
    assert (changed.state, changed.gains[0]) == (running.state, BRISK.backstepping)


def test_a_change_before_the_first_step_starts_from_rest():
    # no command has been published yet: the robot stands
    _, command = step(change(begin(GENTLE, DT, under_way=False), BRISK, DT), SEEN, DT)
    assert command == pytest.approx((0.0, 0.0), abs=1e-15)


@pytest.mark.parametrize(('limits', 'command', 'before', 'limited'), [
    (Limits(), (1e9, -1e9), (0.0, 0.0), (1e9, -1e9)),
    (Limits(linear_velocity=0.5), (-0.7, 3.0), (0.0, 0.0), (-0.5, 3.0)),
    (Limits(angular_velocity=2.0), (0.7, 3.0), (0.0, 0.0), (0.7, 2.0)),
    (Limits(linear_acceleration=1.0), (0.7, 3.0), (0.2, 0.0), (0.3, 3.0)),
    (Limits(linear_acceleration=1.0), (-0.7, 3.0), (0.2, 0.0), (0.1, 3.0)),
    (Limits(angular_acceleration=5.0), (0.7, 3.0), (0.2, 1.0), (0.7, 1.5)),
    (Limits(linear_acceleration=1.0), (0.25, 3.0), (0.2, 0.0), (0.25, 3.0)),
    # beyond what a message may hold, limits or none
    (Limits(), (1e15, -math.inf), (0.0, 0.0), (1e12, -1e12)),
    (Limits(linear_velocity=1e15), (-1e15, 0.0), (0.0, 0.0), (-1e12, 0.0)),
    # lowered while the robot is faster than that: the velocity limit wins
    (Limits(linear_velocity=0.5, linear_acceleration=1.0), (2.0, 0.0), (2.0, 0.0), (0.5, 0.0)),
])
def test_each_component_is_limited_by_itself(limits, command, before, limited):
    found = limit_command(BodyVelocity(*command), BodyVelocity(*before), limits, 0.1)
    assert found == pytest.approx(limited, rel=1e-15)


def test_limits_changed_live_hold_for_the_running_law():
    running, _ = step(begin(PositionControl(), 0.1, under_way=False), seen((0.0, 0.0, 0.0), (1.0, 1.0)), 0.1)
    limits, faster = Limits(linear_velocity=0.4, angular_acceleration=1.0), seen((0.0, 0.0, 0.0), (1.0, 5.0))
    running, command = step(change(running, PositionControl(limits=limits), 0.1), faster, 0.1)
    assert command == pytest.approx((0.4, 1.0))
    # the step to 5 rad/s fades in within 0.2 s, faster than 1 rad/s² allows
    assert step(running, faster, 0.1)[1] == pytest.approx((0.4, 1.1))


def test_the_command_leads_before_its_limits_and_a_change_of_the_lead_is_no_jump():
    control = PositionControl(feedforward=Feedforward((0.15, 0.1), (0.05, 0.15)))
    acceleration = BodyAcceleration(1.0, -0.5)
    begun = begin(control, 0.02, under_way=False)
    running, command = step(begun, ON_THE_CART, 0.02, acceleration)
    assert command == pytest.approx((0.5 + 0.2 * 1.0, 0.2 - 0.25 * 0.5))
    slow = begun._replace(limits=Limits(linear_velocity=0.6))
    assert step(slow, ON_THE_CART, 0.02, acceleration)[1].linear == 0.6
    assert step(begun, ON_THE_CART, 0.02)[1] == pytest.approx((0.5, 0.2))
    running = change(running, PositionControl(), 0.02)
    for _ in range(100):
        last = command
        running, command = step(running, ON_THE_CART, 0.02, acceleration)
        assert abs(command.linear - last.linear) < 0.025
    assert command == pytest.approx((0.5, 0.2), abs=1e-4)


def test_a_law_is_one_file_and_one_line_in_the_package(tmp_path):
    package = Path(mobile_robot_control.__file__).parent
    copy = tmp_path / package.name
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copy(Path(__file__).parents[2] / 'plugins' / 'kanayama.py', copy / 'control' / 'my_kanayama.py')
    laws = copy / 'control' / 'laws.py'
    laws.write_text(laws.read_text().replace("    'fuzzy',\n", "    'fuzzy',\n    'my_kanayama',\n"))

    def run(*arguments):
        return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=True, cwd=tmp_path,
                              env=os.environ | {'PYTHONPATH': str(tmp_path)}).stdout

    done = run('-m', 'mobile_robot_control.runs.command', '--duration', '0.1', '--json', '-p',
               'position_controller.controller_type:=my_kanayama', '-p', 'position_controller.my_kanayama.p:=3.0')
    assert json.loads(done)['outcome'] == 'completed'
    searches = run('-c', 'from mobile_robot_control.search.space import SEARCHES; print([*SEARCHES])')
    before = [law.name for law in BUILT_IN]
    assert ast.literal_eval(searches) == ['velocity', *before[:3], 'my_kanayama', *before[3:]]
