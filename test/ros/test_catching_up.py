"""What has arrived when a recording ends is recorded, and nothing is waited for."""

import time

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import String

from mobile_robot_control.ros.spin import catch_up, make_executor

MANY = 500


@pytest.fixture
def node(domain):
    rclpy.init(args=[])
    yield rclpy.create_node('slow')
    rclpy.shutdown()


def test_all_that_has_arrived_is_handled_and_a_talker_does_not_hold_it_up(node):
    executor, received = make_executor(), []
    if isinstance(executor, SingleThreadedExecutor):
        pytest.skip('this rclpy has no EventsExecutor')
    publisher = node.create_publisher(String, 'talk', MANY)

    node.create_subscription(String, 'talk', lambda message: received.append(message.data), MANY)
    executor.add_node(node)
    deadline = time.monotonic() + 30.0
    while not received:
        assert time.monotonic() < deadline
        publisher.publish(String(data='begin'))
        executor.spin_once(timeout_sec=0.05)
    for number in range(MANY):
        publisher.publish(String(data=str(number)))
    time.sleep(0.5)
    assert str(MANY - 1) not in received
    # a talker without end
    node.create_timer(0.0, lambda: publisher.publish(String(data='more')))
    begun = time.monotonic()
    catch_up(executor, 60.0)
    assert [text for text in received if text.isdigit()] == [str(number) for number in range(MANY)]
    assert time.monotonic() - begun < 30.0


def test_it_ends_in_time(node):
    executor = make_executor()
    executor.add_node(node)
    node.create_timer(0.0, lambda: time.sleep(0.01))
    begun = time.monotonic()
    catch_up(executor, 0.5)
    assert time.monotonic() - begun < 5.0
