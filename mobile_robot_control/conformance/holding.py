"""A record that is registered for its checks alone."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from mobile_robot_control.registry import Registry


@contextmanager
def holding(registry: Registry[Any], record: Any) -> Iterator[None]:
    """Hold a record while a block runs, then forget it again; raise PluginError if it is refused."""
    before = registry.get(getattr(record, 'name', ''))
    if before is record:
        yield
        return
    registry.register(record)
    try:
        yield
    finally:
        if before is None:
            registry.remove(record.name)
        else:
            registry.register(before)
