"""Descriptions of parameters: each gain and each constant of the robot says what a larger value does."""

from each import each

from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.parameters.declaration import declarations

ALL = {name: declared for group in NODES.values() for name, declared in declarations(group).items()}
# places, pauses and positions in time: a larger value does nothing to the robot
NOT_A_SIZE = {'hold_at', 'initial_pose', 'center', 'rotation'}
SIZES = [name for name, declared in ALL.items()
         if (declared.field.live or name.startswith('robot.')) and declared.kind in (float, tuple)
         and name not in NOT_A_SIZE]


@each(SIZES)
def test_it_says_what_a_larger_value_does(name):
    assert 'larger' in ALL[name].field.description


@each(ALL)
def test_it_has_a_description_of_more_than_its_name(name):
    description = ALL[name].field.description
    assert len(description) > 5
    assert not description.endswith('.')
