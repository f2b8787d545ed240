"""A law chosen on the page comes with its shipped set, all of it or nothing, leaves the user's gains, and is undone."""

import asyncio

import pytest

from mobile_robot_control.dashboard.law_choice import LawChoice
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.settings.configure import configure


class Robot:
    """Stands for the nodes; a node that refuses changes nothing."""

    def __init__(self):
        self.values = {node: {name: list(value) if isinstance(value, tuple) else value
                              for name, value in flatten(part).items()}
                       for node, part in configure({})._asdict().items()}
        self.refusing = ''

    async def present(self):
        return {node: dict(values) for node, values in self.values.items()}

    async def change(self, node, values):
        if node == self.refusing:
            raise ValueError('refused')
        self.values[node] |= values


@pytest.fixture
def chosen():
    robot = Robot()
    return robot, LawChoice(robot.present, robot.change)


def _shown(chosen):
    robot, choice = chosen
    found = choice.shown(robot.values)
    return found['gains'], found['before']


def test_a_law_comes_with_its_set_which_is_undone_at_once(chosen):
    robot, choice = chosen
    before = asyncio.run(robot.present())
    assert _shown(chosen) == ('shipped', '')
    asyncio.run(choice.choose('fuzzy', whole=False))
    assert robot.values['position_controller']['fuzzy.a'] == 0.0523369
    assert robot.values['velocity_controller']['gains.k1'] == 0.498752
    assert _shown(chosen) == ('shipped', 'backstepping')
    asyncio.run(choice.choose('fuzzy', whole=False))
    assert _shown(chosen) == ('shipped', 'backstepping')
    asyncio.run(choice.undo())
    assert robot.values == before
    assert _shown(chosen) == ('shipped', '')


def test_gains_that_the_user_has_set_stay_until_the_shipped_ones_are_asked_for(chosen):
    robot, choice = chosen
    robot.values['position_controller']['fuzzy.a'] = 0.3
    asyncio.run(choice.choose('fuzzy', whole=False))
    assert robot.values['position_controller']['fuzzy.a'] == 0.3
    assert robot.values['velocity_controller']['gains.k1'] == 0.498752
    assert _shown(chosen) == ('changed', 'backstepping')
    asyncio.run(choice.choose('', whole=True))
    assert _shown(chosen) == ('shipped', 'fuzzy')
    asyncio.run(choice.undo())
    assert robot.values['position_controller']['fuzzy.a'] == 0.3


def test_a_refused_choice_changes_nothing(chosen):
    robot, choice = chosen
    before = asyncio.run(robot.present())
    robot.refusing = 'position_controller'
    with pytest.raises(ValueError, match='refused'):
        asyncio.run(choice.choose('fuzzy', whole=False))
    assert robot.values == before
    assert _shown(chosen) == ('shipped', '')


def test_another_robot_changes_the_law_alone(chosen):
    robot, choice = chosen
    robot.values['position_controller']['robot.mass'] = 5.0
    before = asyncio.run(robot.present())
    asyncio.run(choice.choose('fuzzy', whole=True))
    before['position_controller']['controller_type'] = 'fuzzy'
    assert robot.values == before
    assert _shown(chosen) == ('', 'backstepping')
