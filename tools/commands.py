"""The commands of the package and their modules."""

from mobile_robot_control.__main__ import COMMANDS


def command_modules() -> dict[str, str]:
    """Return the module of each command, in the order of their list."""
    return {name: f'mobile_robot_control.{folder}.command' for name, folder in COMMANDS.items()}
