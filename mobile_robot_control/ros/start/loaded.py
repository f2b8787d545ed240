"""What a process of nodes loads by name: its signals are caught first, and a node imports no other one."""

from importlib import import_module
from typing import Any

LOADED = {
    'spin': 'mobile_robot_control.ros.start.spin:spin',
    'plant': 'mobile_robot_control.ros.plant.plant:Plant',
    'velocity_controller': 'mobile_robot_control.ros.velocity.velocity_controller:VelocityController',
    'position_controller': 'mobile_robot_control.ros.position.position_controller:PositionController',
    'reference_cart': 'mobile_robot_control.ros.cart.reference_cart:ReferenceCart',
    'own_node': 'mobile_robot_control.ros.own_node.step_node:StepNode',
}
"""Modules and what is taken from them, as entry points have them."""


def load(name: str) -> Any:
    """Import and return one of LOADED."""
    module, _, attribute = LOADED[name].partition(':')
    return getattr(import_module(module), attribute)
