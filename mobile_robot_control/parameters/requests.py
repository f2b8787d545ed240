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

import inspect
import re
import textwrap
from collections.abc import Callable, Collection, Iterator, Mapping
from os import PathLike
from types import NoneType, UnionType
from typing import Annotated, Any, NamedTuple, TypeVar, Union, get_args, get_origin, get_type_hints

from mobile_robot_control.parameters.declaration import (
    Declaration,
    Field,
    Inline,
    ParameterError,
    check_value,
    describe_bounds,
    nearest,
)
from mobile_robot_control.system.texts import printable

Request = TypeVar('Request')
Function = TypeVar('Function', bound=Callable[..., Any])


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
    example : str
        As on a command line, for its help.
    python : type or None
        Type of the whole field in Python; None for a text or a collection of texts.

    """

    read: Callable[[Any], Any]
    form: str
    again: bool = False
    example: str = ''
    python: Any = None


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

    @property
    def python(self) -> Any:
        """The type of its values in Python."""
        kind = self.kind if self.reader is None else str
        whole = (self.reader and self.reader.python) or (Collection[kind] if self.is_several else kind)  # type: ignore[valid-type]
        return whole if self.is_required or self.default is not None else whole | None

    @property
    def bounds(self) -> str:
        """The values that it allows, such as 'above 0.0'; '' if any is allowed."""
        return '' if self.kind is bool else describe_bounds(self.field._replace(unit='', length=None))

    @property
    def meaning(self) -> str:
        """Its description with its unit."""
        return f'{self.field.description} [{self.field.unit}]' if self.field.unit else self.field.description

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

    def value(self, wanted: Any) -> Any:
        """Convert a value to that of the field; raise ParameterError if it is not allowed."""
        wanted = wanted.tolist() if hasattr(wanted, 'tolist') else wanted
        if wanted is None and not self.is_required:
            return self.default
        if not self.is_several:
            return self.element(wanted)
        if isinstance(wanted, Mapping):
            wanted = list(wanted.items())
        elements = [wanted] if isinstance(wanted, str | PathLike | int | float) else list(wanted)
        if self.field.length is not None and len(elements) not in (0, self.field.length):
            raise ParameterError([f'{self.name} = {wanted!r} has {len(elements)} elements; write {self.field.length}'])
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


def make_request(request: type[Request], keywords: Mapping[str, Any]) -> Request:
    """
    Make a request from values by field name, checked as a whole.

    Parameters
    ----------
    request : type
        The NamedTuple.
    keywords : mapping of str to object
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
    violations = [f"unknown option '{printable(name)}'; {nearest(name, options)}" for name in keywords
                  if name not in options and name not in request._fields]  # type: ignore[attr-defined]
    for name, option in options.items():
        if option.is_required and keywords.get(name) is None:
            violations.append(f'{name} is missing; it is needed: {option.field.description}')
            continue
        try:
            values[name] = option.value(keywords.get(name))
        except ParameterError as error:
            violations += error.violations
    if violations:
        raise ParameterError(violations)
    return assemble(request, {**keywords, **values})


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


def takes_fields(request: type) -> Callable[[Function], Function]:
    """
    Complete a function of the Python API from a request; a decorator.

    A last parameter ``**options`` gives way to a keyword for each field that the signature lacks. The section
    Parameters of the docstring gets an entry for each parameter that it lacks, from the description of the field.
    """
    def completed(function: Function) -> Function:
        own, options = inspect.signature(function), options_of(request)
        parameters = [one for one in own.parameters.values() if one.kind != one.VAR_KEYWORD]
        if len(parameters) < len(own.parameters):
            parameters += [inspect.Parameter(
                name, inspect.Parameter.KEYWORD_ONLY, annotation=option.python,
                default={} if get_origin(option.python) is Mapping else option.default)
                           for name, option in options.items() if name not in own.parameters]
            function.__signature__ = own.replace(parameters=parameters)  # type: ignore[attr-defined]
        # Python with -OO has no docstrings
        if function.__doc__:
            head, title, rest = inspect.cleandoc(function.__doc__).partition('Parameters\n----------\n')
            section, _, tail = rest.partition('\n\n')
            written = {entry.partition(' : ')[0].strip('*'): entry for entry in re.split(r'\n(?=\S)', section)}
            entries = [written.get(one.name) or _entry(options[one.name], one.annotation) for one in parameters]
            function.__doc__ = '\n'.join([head + title + '\n'.join(entries), '', tail])
        return function

    return completed


def _entry(option: Option, annotation: Any) -> str:
    """Return the entry of a field in the section Parameters of a docstring."""
    meaning = f'if {not option.default}, {option.meaning}' if option.kind is bool else option.meaning
    # those of a registry may change, and are listed by the command line
    bounds = option.bounds if isinstance(option.field.choices, tuple) else ''
    sentence = f'{meaning[0].upper()}{meaning[1:]}{f" ({bounds})" if bounds else ""}.'
    return f'{option.name} : {_type_text(annotation)}\n{textwrap.indent(textwrap.fill(sentence, 100), "    ")}'


def _type_text(annotation: Any) -> str:
    """
    Return a type as in docstrings.

    Examples
    --------
    >>> _type_text(Mapping[str, tuple[float, float]] | None), _type_text(Collection[str | PathLike[str]])
    ('mapping of str to (float, float) or None', 'collection of path')

    """
    origin, parts = get_origin(annotation), [*map(_type_text, get_args(annotation))]
    if origin in (Union, UnionType):
        return ' or '.join(parts[parts[:2] == ['str', 'path']:])
    if origin is tuple:
        return f'({", ".join(parts)})'
    if origin is PathLike:
        return 'path'
    if origin is not None:
        return f'{origin.__name__.lower()} of {" to ".join(parts)}'
    return 'None' if annotation is NoneType else str(annotation.__name__)


def refuse_files(options: Collection[str]) -> None:
    """Raise ParameterError if keywords of a function of the Python API are options of a command that name files."""
    unused = [f'{name}: nothing is written to files from Python; leave it out, and call report() of the result'
              for name in ('output', 'overwrite', 'resume') if name in options]
    if unused:
        raise ParameterError(unused)


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
