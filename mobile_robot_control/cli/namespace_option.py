"""The option `--namespace`, of the commands that deal with nodes over DDS."""

import argparse

from mobile_robot_control.parameters.addressing import namespace_fault


def _namespace(text: str) -> str:
    """Read a namespace that ROS takes."""
    fault = namespace_fault(text)
    if fault:
        raise argparse.ArgumentTypeError(fault)
    return text


def add_namespace_option(parser: argparse.ArgumentParser, description: str) -> None:
    """Declare ``--namespace``, the root by default."""
    parser.add_argument('--namespace', type=_namespace, default='/', metavar='NS', help=description)
