"""Trees of NamedTuples as rows of floats, and back, by generated functions: plain, compiled or on a GPU."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from mobile_robot_control.jit import jitable, jitable_apart

Shape = Any
"""A type of number, or a type of tuple with the shapes of its items; hashable."""

_READ = {float: 'row[{}]', int: 'int(row[{}])', bool: 'row[{}] != 0.0'}


def shape_of(tree: object) -> Shape:
    """Return the shape of a tree of tuples, NamedTuples, floats, integers up to 2**53 and bools."""
    if isinstance(tree, tuple):
        return type(tree), tuple(map(shape_of, tree))
    if type(tree) not in _READ:
        raise TypeError(f'a row of floats cannot hold {tree!r}')
    return type(tree)


def flat(tree: Any) -> list[float]:
    """
    Return the numbers of a tree as floats, in order.

    Examples
    --------
    >>> flat((1, (2.5, True)))
    [1.0, 2.5, 1.0]

    """
    return [one for part in tree for one in flat(part)] if isinstance(tree, tuple) else [float(tree)]


@lru_cache(maxsize=256)
def reader(shape: Shape) -> Callable[[Any], Any]:
    """
    Make the function that returns the tree of a shape from its row.

    Examples
    --------
    >>> reader(shape_of((1, (2.5, True))))([1.0, 2.5, 1.0])
    (1, (2.5, True))

    """
    kinds: list[type] = []
    places = iter(range(1 << 30))

    def source(shape: Shape) -> str:
        if not isinstance(shape, tuple):
            return _READ[shape].format(next(places))
        kind, parts = shape
        items = ''.join(f'{source(part)}, ' for part in parts)
        if kind is tuple:
            return f'({items})'
        if kind not in kinds:
            kinds.append(kind)
        return f'T{kinds.index(kind)}({items})'

    body = source(shape)
    read: Callable[[Any], Any] = eval(  # noqa: S307 (of types and places alone)
        f'lambda row: {body}', {f'T{n}': kind for n, kind in enumerate(kinds)})
    return jitable_apart(read)




@lru_cache(maxsize=256)
def writer(shape: Shape) -> Callable[[Any, Any], None]:
    """
    Make the function that writes a tree of a shape into a row.

    Examples
    --------
    >>> row = [0.0] * 3
    >>> writer(shape_of((1, (2.5, True))))(row, (1, (2.5, True)))
    >>> row
    [1, 2.5, 1.0]

    """
    lines: list[str] = []

    def add(shape: Shape, at: str) -> None:
        if isinstance(shape, tuple):
            for n, part in enumerate(shape[1]):
                add(part, f'{at}[{n}]')
        else:
            lines.append(f'    row[{len(lines)}] = {f"1.0 if {at} else 0.0" if shape is bool else at}\n')

    add(shape, 'tree')
    namespace: dict[str, Any] = {}
    exec(f'def write(row, tree):\n{"".join(lines)}', namespace)  # noqa: S102 (of places alone)
    function: Callable[[Any, Any], None] = namespace['write']
    return jitable_apart(function)


@lru_cache(maxsize=256)
def repeated(times: int) -> Callable[[Any], tuple[Any, ...]]:
    """
    Make the function that returns a tuple of so many equal items; a compiler does not multiply tuples.

    Examples
    --------
    >>> repeated(3)(0.5)
    (0.5, 0.5, 0.5)

    """
    made: Callable[[Any], tuple[Any, ...]] = eval(f'lambda item: ({"item, " * times})')  # noqa: S307 (of a number)
    return jitable(made)


@lru_cache(maxsize=256)
def replacing(kind: Any, *names: str) -> Callable[..., Any]:
    """
    Make the function that returns a NamedTuple with other values of some fields; a compiler has no `_replace`.

    Examples
    --------
    >>> from mobile_robot_control.quantities import Pose
    >>> replacing(Pose, 'y', 'heading')(Pose(1.0, 2.0, 3.0), 0.0, 0.5)
    Pose(x=1.0, y=0.0, heading=0.5)

    """
    items = ', '.join(name if name in names else f'item.{name}' for name in kind._fields)
    made: Callable[..., Any] = eval(f'lambda item, {", ".join(names)}: T({items})', {'T': kind})  # noqa: S307 (of names)
    return jitable(made)
