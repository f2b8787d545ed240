"""The gains that a search may change."""

from typing import Any, NamedTuple

from mobile_robot_control.control.laws import PositionControl
from mobile_robot_control.control.selection import Selection
from mobile_robot_control.control.velocity_laws import VelocityControl
from mobile_robot_control.settings.nodes import Configuration


class Gains(NamedTuple):
    """The gains that a search may change: those of the velocity law and of the position laws."""

    velocity: VelocityControl
    control: PositionControl

    def group(self, node: str, name: str) -> Any:
        """Return a group of gains of a node by name."""
        return getattr(self.velocity if node == 'velocity_controller' else self.control, name)

    def with_group(self, node: str, name: str, group: Any) -> 'Gains':
        """Return the gains with another group."""
        if node == 'velocity_controller':
            return self._replace(velocity=self.velocity._replace(**{name: group}))
        return self._replace(control=self.control._replace(**{name: group}))


def rounded(gains: Gains) -> Gains:
    """Return gains rounded to six significant digits, finer than the resolution of a gene."""
    short: Gains = _rounded(gains)
    return short


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f'{value:.6g}')
    if isinstance(value, Selection):
        return type(value)(**{name: _rounded(part) for name, part in value._asdict().items()})
    if isinstance(value, tuple):
        parts = map(_rounded, value)
        return type(value)(*parts) if hasattr(value, '_fields') else tuple(parts)
    return value


def configured_gains(configuration: Configuration) -> Gains:
    """Return the gains of a configuration."""
    return Gains(configuration.velocity_controller.control, configuration.position_controller.control)
