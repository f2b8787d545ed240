"""The law that `controller_type` selects, with the gains of all laws of its registry."""

from collections.abc import Iterator
from typing import Any, ClassVar, TypeVar

from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.parameters.registry import Registry

Selected = TypeVar('Selected', bound='Selection')


class Selection:
    """
    The selected law of a registry, and the gains of all its laws.

    It acts as a NamedTuple with the fields `controller_type`, one group for each registered law, and those of
    `further`; omitted fields have their defaults.

    Parameters
    ----------
    **values : object
        By field.

    Attributes
    ----------
    registry : Registry
        Of the laws, each with its `name`, its `group` of parameters and the type of its `gains`.
    default, description : str
        Name of the law where none is selected; what `controller_type` is.
    further : dict of str to NamedTuple
        Groups beside those of the laws, with their defaults.

    """

    registry: ClassVar[Registry[Any]]
    default: ClassVar[str]
    description: ClassVar[str]
    further: ClassVar[dict[str, Any]] = {}

    # positional: a law may be called self
    def __init__(self, /, **values: Any) -> None:
        unknown = set(values) - {name for name, _, _ in self.parameter_members()}
        if unknown:
            raise TypeError(f'{type(self).__name__} has no field {", ".join(sorted(unknown))}')
        self.__dict__.update(values)

    @classmethod
    def parameter_members(cls) -> Iterator[tuple[str, type, Any]]:
        """Yield name, type and annotation of each field."""
        yield 'controller_type', str, Field('', cls.description, choices=cls.registry, live=True)
        for law in cls.registry.values():
            yield law.group, law.gains, None
        for group, default in cls.further.items():
            yield group, type(default), None

    def __getattr__(self, name: str) -> Any:
        if name == 'controller_type':
            return self.default
        if name in self.further:
            return self.further[name]
        gains = None if name.startswith('_') else next(
            (law.gains for law in self.registry.values() if law.group == name), None)
        if gains is None:
            raise AttributeError(name)
        return gains()

    def _replace(self: Selected, /, **changes: Any) -> Selected:
        return type(self)(**{**self.__dict__, **changes})

    def _asdict(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name, _, _ in self.parameter_members()}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and self._asdict() == other._asdict()

    def __hash__(self) -> int:
        return hash(tuple(self._asdict().items()))

    def __repr__(self) -> str:
        return f'{type(self).__name__}({", ".join(f"{name}={value!r}" for name, value in self._asdict().items())})'
