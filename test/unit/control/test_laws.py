"""The registry of position laws."""

import pytest
from each import each_row

from mobile_robot_control.configuration.files import is_ros_parameter
from mobile_robot_control.configuration.nodes import PositionControllerParameters
from mobile_robot_control.control import backstepping, fuzzy, hybrid_backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.dynamic_feedback_linearization import CompensatorState
from mobile_robot_control.control.hybrid_backstepping import HybridState, SeekingGains
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.laws import LAWS, RESERVED, PositionControl, law_violations, select
from mobile_robot_control.control.membership import FuzzyGains
from mobile_robot_control.control.sliding_mode import SlidingState
from mobile_robot_control.parameters.checking import ParameterError, build
from mobile_robot_control.parameters.declaration import declarations

PARAMETERS = PositionControl(
    backstepping=BacksteppingGains(p=2.5), hybrid_backstepping=SeekingGains(b1=3.0), fuzzy=FuzzyGains(a=0.7))


@each_row(('name', 'step', 'gains'), [
    ('backstepping', backstepping.step, PARAMETERS.backstepping),
    ('hybrid_backstepping', hybrid_backstepping.step,
     (PARAMETERS.backstepping, PARAMETERS.hybrid_backstepping)),
    ('fuzzy', fuzzy.step, PARAMETERS.fuzzy),
])
def test_select_gives_the_law_with_its_gains(name, step, gains):
    law, selected = select(PARAMETERS._replace(controller_type=name), 0.01)
    assert law.step is step
    assert selected == gains


def test_each_law_has_a_state_to_start_and_one_to_join_a_run():
    assert {name: (law.start, law.joining) for name, law in LAWS.items()} == {
        'backstepping': (NoState(), None), 'fuzzy': (NoState(), None),
        'hybrid_backstepping': (HybridState(), hybrid_backstepping.TRACKING), 'kanayama': (NoState(), None),
        'ramsete': (NoState(), None), 'periodic': (NoState(), None),
        'dynamic_feedback_linearization': (CompensatorState(), None), 'sliding_mode': (SlidingState(), None),
        'lqr': (NoState(), None)}


def test_an_unknown_law_is_refused_with_the_nearest_name():
    with pytest.raises(ParameterError, match="did you mean 'hybrid_backstepping'"):
        build(PositionControl, {'controller_type': 'hybrid_backsteping'})


def test_the_names_that_no_law_may_have_are_those_of_the_node():
    first_words = {name.partition('.')[0] for name in declarations(PositionControllerParameters)} - set(LAWS)
    assert first_words <= RESERVED
    assert not any(is_ros_parameter(name) for name in LAWS)


def test_parameters_are_equal_where_all_of_them_are():
    assert PARAMETERS == PARAMETERS._replace() != PARAMETERS._replace(controller_type='fuzzy')
    assert PARAMETERS.backstepping != PARAMETERS


@each_row('horizon', [-1, 1.5, None])
def test_a_law_whose_horizon_is_no_number_of_ticks_is_refused(horizon):
    refusal, = law_violations(LAWS['fuzzy']._replace(horizon=horizon))
    assert refusal == f"'fuzzy': its horizon is {horizon}; write the number of position ticks ahead"
