"""
The only declaration mechanism: parameters are annotated fields of NamedTuples.

One declaration feeds the check of YAML files, the ROS descriptor, the command line and the tables in docs/::

    class Robot(NamedTuple):
        mass: Annotated[float, Field('kg', 'mass of the entire vehicle', above=0.0)] = 10.0

A field with a NamedTuple as its type is a group: the names of its fields have its name and a dot as prefix
(``robot.mass``), or no prefix if it is annotated with ``INLINE``.
"""

from collections.abc import Collection, Iterator
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints


class Field(NamedTuple):
    """
    The properties of a parameter, beyond its type and default.

    Attributes
    ----------
    unit : str
        SI unit, '' for a pure number or a text.
    description : str
        Its meaning or the effect of a larger value, and the chapter's symbol or source if there is one.
    above, minimum, maximum, below : float or None
        Bounds: value > above, value >= minimum, value <= maximum, value < below; for an array, of each element.
    length : int or None
        Number of elements of an array.
    choices : collection of str
        The allowed texts, in the order of messages; if empty, every text except '' is allowed.
    live : bool
        Whether it may change while the node runs.
    search : tuple
        Lower and upper bound in a search for the parameter, for an array one pair for each element; () excludes it.

    """

    unit: str
    description: str
    above: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    length: int | None = None
    choices: Collection[str] = ()
    live: bool = False
    search: tuple[Any, ...] = ()
    below: float | None = None


class Inline(NamedTuple):
    """Marks a group whose fields have no prefix."""


INLINE = Inline()


class Declaration(NamedTuple):
    """
    One parameter: its dotted name, its Python type, its field and its default.

    Attributes
    ----------
    name : str
        Dotted name, as in a YAML file.
    kind : type
        float, int, bool, str, or tuple (an array of float).
    field : Field
        Unit, description, bounds.
    default : object
        The value if no other is given.

    """

    name: str
    kind: type
    field: Field
    default: Any


def members(group: type) -> Iterator[tuple[str, type, Any]]:
    """Yield name, bare type and annotation (Field, Inline or None) of each field of a group."""
    # the fields of some groups depend on the registry
    yield from group.parameter_members() if hasattr(group, 'parameter_members') else _fields(group)


@lru_cache(maxsize=128)
def _fields(group: type) -> tuple[tuple[str, type, Any], ...]:
    """Return the fields of a NamedTuple; cached, because a search needs them for every individual."""
    found = []
    for name, hint in get_type_hints(group, include_extras=True).items():
        annotation = get_args(hint)[1] if get_origin(hint) is Annotated else None
        bare = get_args(hint)[0] if get_origin(hint) is Annotated else hint
        found.append((name, get_origin(bare) or bare, annotation))
    return tuple(found)


def group_prefix(prefix: str, name: str, annotation: Any) -> str:
    """Return the prefix of the names of a group's fields."""
    return prefix if isinstance(annotation, Inline) else f'{prefix}{name}.'


def declarations(group: type, prefix: str = '', defaults: Any = None) -> dict[str, Declaration]:
    """
    List the parameters that a NamedTuple declares, including those of its groups.

    Parameters
    ----------
    group : type
        A NamedTuple with fields that are groups or annotated with Field; each has a default.
    prefix : str
        Put before each name.
    defaults : group or None
        Source of the defaults; the class itself if None.

    Returns
    -------
    dict of str to Declaration
        By dotted name, in the order of declaration.

    Examples
    --------
    >>> from typing import NamedTuple
    >>> class Wheel(NamedTuple):
    ...     radius: Annotated[float, Field('m', 'of the wheel', above=0.0)] = 0.035
    >>> declarations(Wheel)['radius'].default
    0.035

    """
    values = group() if defaults is None else defaults
    found: dict[str, Declaration] = {}
    for name, kind, annotation in members(group):
        default = getattr(values, name)
        if isinstance(annotation, Field):
            found[prefix + name] = Declaration(prefix + name, kind, annotation, default)
        else:
            found.update(declarations(kind, group_prefix(prefix, name, annotation), default))
    return found


def flatten(values: Any) -> dict[str, Any]:
    """Return the parameters of a group's instance by dotted name, arrays as tuples: the inverse of `build`."""
    return {name: declared.default for name, declared in declarations(type(values), defaults=values).items()}
