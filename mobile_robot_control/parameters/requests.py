"""
Requests: the input of a command, or of a function of the Python API.

A request is a NamedTuple whose fields are declared with `Field`, as parameters are::

    class Draw(NamedTuple):
        sources: ParameterSources
        runs: Annotated[int, Field('', 'random runs', minimum=1)]
        scales: Annotated[tuple[float, ...], Field('m', 'sizes of the curves', above=0.0)] = (0.5, 1.0)
        start: Annotated[tuple[Pose, ...], Field('', 'start'), Reader(read_pose, 'DX,DY,DYAW', again=True)] = ()

A field without a default is required; a field with the default None is optional. A command line derives its options
from these fields, and a function its checks of keywords. A group within a request, such as `sources`, is a value of its
own; if it is annotated with ``INLINE``, its fields are among those of the request.
"""

from collections.abc import Callable, Iterator, Mapping
from os import PathLike
from types import NoneType
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

from mobile_robot_control.parameters.declaration import Declaration, Field, Inline, ParameterError, check_value, nearest
from mobile_robot_control.system.texts import printable

Request = TypeVar('Request')


class Reader(NamedTuple):
    """
    The conversion of a value that is neither a number nor a text.

    Attributes
    ----------
    read : callable
        Takes a text of a command line or a Python value; raises ValueError with a remedy if it is invalid.
    form : str
        Form of the text.
    again : bool
        Whether an option of a command line takes one value, and is given again for the next.

    """

    read: Callable[[Any], Any]
    form: str
    again: bool = False


class Option(NamedTuple):
    """
    One field of a request.

    Attributes
    ----------
    name : str
        Of the field.
    kind : type
        float, int, bool or str; for several values, of each.
    field : Field
        Unit, description, bounds.
    default : object
        None if there is none.
    is_required, is_several : bool
        Whether it is required; whether it is a tuple.
    reader : Reader or None
        Conversion of the value, or of each element.

    """

    name: str
    kind: type
    field: Field
    default: Any
    is_required: bool
    is_several: bool
    reader: Reader | None

    def element(self, value: Any) -> Any:
        """Convert a value, or an element of it, to its type; raise ParameterError if it is not allowed."""
        if self.reader is not None:
            try:
                return self.reader.read(value)
            except (ValueError, TypeError) as error:
                raise ParameterError([f'{self.name} = {printable(repr(value))}: {error}']) from None
        example = self.default if not self.is_several else next(iter(self.default or ()), None)
        bounds = self.field._replace(length=None)
        taken, violations = check_value(Declaration(self.name, self.kind, bounds, example), value)
        if violations:
            raise ParameterError(map(printable, violations))
        return taken

    def value(self, given: Any) -> Any:
        """Convert a value to that of the field; raise ParameterError if it is not allowed."""
        given = given.tolist() if hasattr(given, 'tolist') else given
        if given is None and not self.is_required:
            return self.default
        if not self.is_several:
            return self.element(given)
        if isinstance(given, Mapping):
            given = list(given.items())
        elements = [given] if isinstance(given, str | PathLike | int | float) else list(given)
        if self.field.length is not None and len(elements) not in (0, self.field.length):
            raise ParameterError([f'{self.name} = {given!r} has {len(elements)} elements; write {self.field.length}'])
        return tuple(map(self.element, elements))


def options_of(request: type) -> dict[str, Option]:
    """Return the fields of a request by name, including those of its inline groups."""
    return {option.name: option for option in _options(request)}


def _options(request: Any) -> Iterator[Option]:
    for name, hint in get_type_hints(request, include_extras=True).items():
        if get_origin(hint) is not Annotated:
            continue
        kind, *annotations = get_args(hint)
        if isinstance(annotations[0], Inline):
            yield from _options(kind)
            continue
        several = get_origin(kind) is tuple
        kinds = [one for one in get_args(kind) if one not in (NoneType, Ellipsis)]
        default = request._field_defaults.get(name)
        yield Option(name, kinds[0] if kinds else kind, annotations[0], default, name not in request._field_defaults,
                     several, annotations[1] if len(annotations) > 1 else None)


def make_request(request: type[Request], given: Mapping[str, Any]) -> Request:
    """
    Make a request from values by field name, checked as a whole.

    Parameters
    ----------
    request : type
        The NamedTuple.
    given : mapping of str to object
        Omitted fields, and those that are None, keep their defaults. A single text, number or path is accepted for a
        tuple.

    Returns
    -------
    request
        The instance.

    Raises
    ------
    ParameterError
        With every violation and its remedy.

    """
    options = options_of(request)
    values: dict[str, Any] = {}
    violations = [f"unknown option '{printable(name)}'; {nearest(name, options)}" for name in given
                  if name not in options and name not in request._fields]  # type: ignore[attr-defined]
    for name, option in options.items():
        if option.is_required and given.get(name) is None:
            violations.append(f'{name} is missing; it is needed: {option.field.description}')
            continue
        try:
            values[name] = option.value(given.get(name))
        except ParameterError as error:
            violations += error.violations
    if violations:
        raise ParameterError(violations)
    return assemble(request, {**given, **values})


def assemble(request: type[Request], values: Mapping[str, Any]) -> Request:
    """Make a request and its inline groups from checked values by name; other names are ignored."""
    parts = {}
    for name, hint in get_type_hints(request, include_extras=True).items():
        annotation = get_args(hint)[1] if get_origin(hint) is Annotated else None
        if isinstance(annotation, Inline):
            parts[name] = assemble(get_args(hint)[0], values)
        elif name in values:
            parts[name] = values[name]
    return request(**parts)


def read_bounds(value: Any) -> tuple[str, tuple[float, float]]:
    """Read NAME=LOW:HIGH, or a name with a pair of numbers."""
    try:
        if isinstance(value, str):
            name, _, interval = value.partition('=')
            low, _, high = interval.partition(':')
        else:
            name, interval = value
            if isinstance(interval, str):
                raise TypeError
            low, high = interval
        return name, (float(low), float(high))
    except (ValueError, TypeError):
        raise ValueError('write NAME=LOW:HIGH, such as k1=0:5, or a pair (low, high), such as (0.0, 5.0)') from None
