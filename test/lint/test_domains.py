"""Tests start nodes only in a ROS domain of their own."""

import socket

import pytest
import rclpy
from helpers.domains import DOMAINS, own_domain


def test_without_the_fixture_domain_no_node_starts():
    with pytest.raises(RuntimeError, match='ROS_DOMAIN_ID'):
        rclpy.init()


def test_no_test_is_given_a_domain_in_which_somebody_left_a_node():
    with own_domain() as found:
        left = int(found['ROS_DOMAIN_ID'])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as node:
        node.bind(('127.0.0.1', 7410 + 250 * left))
        for _ in DOMAINS:
            with own_domain() as one, own_domain() as another:
                assert len({one['ROS_DOMAIN_ID'], another['ROS_DOMAIN_ID'], str(left)}) == 3
