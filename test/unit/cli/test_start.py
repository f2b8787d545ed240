"""Without `plant.initial_pose` the commands start the robot at the cart's start."""



from mobile_robot_control.cli import simulate, tune
from mobile_robot_control.cli.command_parser import request_of
from mobile_robot_control.configuration.configure import at_cart_start, configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.quantities import Pose
from mobile_robot_control.tuning.searching import Search, SearchRequest


def _search(*arguments):
    words = ['backstepping', '--seed', '1', '--output', 'unused.yaml', *arguments]
    return Search(request_of(SearchRequest, tune.parser().parse_args(words)))


def test_a_given_pose_stays(tmp_path):
    given = 'plant.initial_pose:=[0.8, 0.1, 0.2]'
    assert _search('-p', given, '-p', 'reference_cart.scale:=2.0').parameters.plant.initial_pose == (0.8, 0.1, 0.2)
    file = tmp_path / 'pose.yaml'
    file.write_text('/**/plant: {ros__parameters: {initial_pose: [0.8, 0.1, 0.2]}}')
    assert _search('--params-file', str(file)).parameters.plant.initial_pose == (0.8, 0.1, 0.2)


def test_the_robot_starts_at_the_cart_with_its_heading():
    parameters = _search('-p', 'reference_cart.curve:=lemniscate', '-p', 'reference_cart.scale:=2.0', '-p',
                         'reference_cart.phase:=0.25', '-p', 'reference_cart.center:=[1.0, -3.0]').parameters
    assert parameters == at_cart_start(parameters)
    assert parameters.plant.initial_pose != configure({}).plant.initial_pose == _search().parameters.plant.initial_pose


def test_the_pose_that_was_used_is_recorded(tmp_path, capsys):
    output = tmp_path / 'run.csv'
    assert simulate.main(['--duration', '0.1', '-p', 'reference_cart.scale:=2.0', '--output', str(output)]) == 0
    assert load([output.with_suffix('.parameters.yaml')])['plant']['initial_pose'][0] == 2.0


def test_scenarios_start_with_the_cart_unless_a_pose_is_given():
    for arguments, start in (((), Pose(0.0, 0.0, 0.0)), (('-p', 'plant.initial_pose:=[1.0, 0.0, 0.0]'), None)):
        search = _search('--scales', '0.5', '2.0', *arguments)
        assert [scenario.start for scenario in search.goal.scenarios] == [start, start]
