"""Nodes log one line when they wait, when a run begins and when it ends, and a start far from the cart."""

from mobile_robot_control.configuration.nodes import NODES


def _texts(robot, name):
    """What a node logged, without time stamps."""
    return [line.partition(f'[{name}]: ')[2] for line in robot.log(name).splitlines()]


def test_a_run_from_waiting_to_its_end(robot):
    robot.start(arguments=['-p', 'duration:=1.0', '-p', 'real_time_factor:=0.0', '-p', 'peer_timeout:=60.0'])
    robot.spin_until(lambda: robot.processes['plant'].exit_code() == 0)
    for name in list(NODES)[1:]:
        robot.processes[name].signal(2)
    robot.spin_until(lambda: all(process.exit_code() == 0 for process in robot.processes.values()))
    assert _texts(robot, 'plant') == [
        'waiting for velocity_controller, position_controller, reference_cart', 'a run begins', 'ended at t = 1 s']
    assert _texts(robot, 'position_controller') == [
        'waiting for odom from plant, reference from reference_cart', 'a run begins', 'ended at t = 1 s']
    assert _texts(robot, 'velocity_controller')[1:] == ['a run begins', 'ended at t = 1 s']
    assert _texts(robot, 'reference_cart')[1:] == ['a run begins', 'ended at t = 1 s']


def test_a_start_far_from_the_cart_is_a_warning(robot):
    robot.start(arguments=['-p', 'plant:initial_pose:=[3.0, 0.0, 0.0]', '-p', 'paused:=true'], composed=True)
    robot.spin_until(lambda: 'set plant.initial_pose' in robot.log())
    where = 'the robot is at (3.00, 0.00) m, the cart at (1.00, 0.00) m'
    assert f'the run starts 2.00 m from the cart: {where}' in robot.log()
