"""Without `plant.initial_pose` the commands start the robot at the cart's start."""

import json

import pytest

from mobile_robot_control.cli import simulate
from mobile_robot_control.cli.command_parser import make_parser
from mobile_robot_control.cli.options import configuration
from mobile_robot_control.cli.scenario_options import add_scenario_options, scenarios
from mobile_robot_control.parameters.configuration import at_cart_start, configure
from mobile_robot_control.parameters.files import load
from mobile_robot_control.quantities import Pose


def _options(*arguments):
    parser = make_parser('name', '')
    add_scenario_options(parser)
    return parser.parse_args(arguments)


@pytest.mark.parametrize('curve', ['trifolium', 'lemniscate', 'circle', 'line'])
def test_the_robot_starts_at_the_cart_with_its_heading(curve):
    options = _options('-p', f'reference_cart.curve:={curve}', '-p', 'reference_cart.scale:=2.0', '-p',
                       'reference_cart.phase:=0.25', '-p', 'reference_cart.center:=[1.0, -3.0]')
    parameters = configuration(options)
    assert parameters == at_cart_start(parameters)
    assert parameters.plant.initial_pose != configure({}).plant.initial_pose


def test_the_default_curve_starts_where_a_plant_without_parameters_does():
    assert configuration(_options()) == configure({})


def test_a_given_pose_stays(tmp_path):
    given = 'plant.initial_pose:=[0.8, 0.1, 0.2]'
    assert configuration(_options('-p', given, '-p', 'reference_cart.scale:=2.0')).plant.initial_pose == (0.8, 0.1, 0.2)
    file = tmp_path / 'pose.yaml'
    file.write_text('/**/plant: {ros__parameters: {initial_pose: [0.8, 0.1, 0.2]}}')
    assert configuration(_options('--params-file', str(file))).plant.initial_pose == (0.8, 0.1, 0.2)


def test_a_larger_curve_is_followed_from_the_start(capsys):
    assert simulate.main(['--duration', '4', '-p', 'reference_cart.scale:=2.0', '--json']) == 0
    assert json.loads(capsys.readouterr().out)['max_position_error'] < 0.2


def test_the_pose_that_was_used_is_recorded(tmp_path, capsys):
    output = tmp_path / 'run.csv'
    assert simulate.main(['--duration', '0.1', '-p', 'reference_cart.scale:=2.0', '--output', str(output)]) == 0
    assert load([output.with_suffix('.parameters.yaml')])['plant']['initial_pose'][0] == 2.0


def test_scenarios_start_with_the_cart_unless_a_pose_is_given():
    for arguments, start in (((), Pose(0.0, 0.0, 0.0)), (('-p', 'plant.initial_pose:=[1.0, 0.0, 0.0]'), None)):
        options = _options('--scales', '0.5', '2.0', *arguments)
        assert [scenario.start for scenario in scenarios(options, configuration(options))] == [start, start]
