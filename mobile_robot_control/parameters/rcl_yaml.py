"""YAML as rcl reads and writes it: text that rcl refuses, or reads differently from YAML, is refused."""

import re
from contextlib import suppress
from typing import Any

import yaml
from yaml.events import AliasEvent
from yaml.tokens import DirectiveToken

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.system.texts import shortened

_DEEPEST = 32
"""Levels of nesting; the name of a parameter has only a few."""
_WORDS = {
    **dict.fromkeys(('y', 'Y', 'yes', 'Yes', 'YES', 'true', 'True', 'TRUE', 'on', 'On', 'ON'), True),
    **dict.fromkeys(('n', 'N', 'no', 'No', 'NO', 'false', 'False', 'FALSE', 'off', 'Off', 'OFF'), False),
}
_INTEGER = re.compile(r'[-+]?(0[xX][0-9a-fA-F]{1,17}|[0-9]{1,23})')
_FLOAT = re.compile(r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?')
_NOT_FINITE = re.compile(r'[-+]?((?i:inf|infinity|nan(\(\w*\))?)|\.(inf|Inf|INF))|\.(nan|NaN|NAN)')
_HEXADECIMAL = re.compile(r'[-+]?0x([0-9a-f]+\.?[0-9a-f]*|\.[0-9a-f]+)(p[-+]?\d+)?', re.IGNORECASE)
_NORMAL = 2.0**-1022
"""The smallest number that C's strtod reads without an error; after an error rcl takes the text instead."""


class _Refused(yaml.MarkedYAMLError):
    """YAML that rcl would refuse or read differently."""

    def __init__(self, mark: Any, problem: str) -> None:
        super().__init__(problem=problem, problem_mark=mark)


class _Loader(yaml.SafeLoader):
    """YAML as rcl reads it: 1e-3 is a number, though YAML 1.1 wants 1.0e-3."""

    _depth = 0

    def process_directives(self) -> Any:
        if self.check_token(DirectiveToken):
            token: Any = self.peek_token()  # type: ignore[no-untyped-call]
            raise _Refused(token.start_mark, 'a directive (%...) is not taken by nodes; leave it out')
        return super().process_directives()  # type: ignore[no-untyped-call]

    def compose_node(self, parent: Any, index: Any) -> Any:
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        if isinstance(event, AliasEvent):
            raise _Refused(event.start_mark, f'the alias *{event.anchor} is not taken by nodes; write the value itself')
        if event.anchor is not None:
            raise _Refused(event.start_mark, f'the anchor &{event.anchor} has no use without aliases, which nodes do '
                           'not take; leave it out')
        if event.tag is not None:
            raise _Refused(event.start_mark, f'the tag {event.tag} is not taken by nodes; leave it out, and put a text '
                           'in quotes')
        self._depth += 1
        if self._depth > _DEEPEST:
            raise _Refused(event.start_mark, f'nested more than {_DEEPEST} levels deep; write names with dots')
        node = super().compose_node(parent, index)
        # neither can be part of a C string
        if isinstance(node, yaml.ScalarNode) and any('\ud800' <= letter <= '\udfff' or letter == '\0'
                                                     for letter in node.value):
            raise _Refused(node.start_mark, f"'{shortened(node.value, 60)}' has half a character or a zero byte, which "
                           'nodes do not take; write the text without it')
        self._depth -= 1
        return node

    def value(self, node: Any, within_array: bool = False) -> Any:
        """Return the value of a node."""
        if isinstance(node, yaml.ScalarNode):
            return self._scalar(node)
        if within_array:
            raise _Refused(node.start_mark, 'an array contains an array or a mapping; write only numbers or texts')
        if isinstance(node, yaml.SequenceNode):
            return [self.value(element, within_array=True) for element in node.value]
        values: dict[str, Any] = {}
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise _Refused(key.start_mark, 'a name is no text; write a name before the colon')
            if key.value in values:
                raise _Refused(key.start_mark, f"'{shortened(key.value, 60)}' is written twice in one place; rcl would "
                               'take the first, YAML the last: leave one of them out')
            values[key.value] = self.value(value)
        return values

    def _scalar(self, node: yaml.ScalarNode) -> Any:
        """Return a text, a number, true or false, or None; refuse a scalar that nodes would read differently."""
        if node.style in ("'", '"'):
            return node.value
        in_yaml = self.construct_object(node) if node.style is None else node.value
        if in_yaml is None:
            return None
        in_rcl = as_rcl(node.value)
        # integers beyond 64 bits are floats for rcl; NaN differs from itself
        same = repr(in_yaml) == repr(in_rcl) or (isinstance(in_yaml, int) and isinstance(in_rcl, float))
        if not same:
            shown = shortened(node.value, 60)
            raise _Refused(node.start_mark, f"'{shown}' is {_described(in_rcl)} for nodes, and {_described(in_yaml)} "
                           'in YAML; write a number in decimal digits, true or false, or a text in quotes')
        return in_rcl


class _Dumper(yaml.SafeDumper):
    """YAML for the loader: a text such as '1e-3' needs quotes."""

    def ignore_aliases(self, _: object) -> bool:
        return True


for _side in (_Loader, _Dumper):
    _side.add_implicit_resolver(
        'tag:yaml.org,2002:float',
        re.compile(r'^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$'),
        list('-+0123456789.'),
    )


def _represent_text(dumper: _Dumper, scalar: str) -> Any:
    """Write a text, in quotes if rcl would read it as something else."""
    style = None if isinstance(as_rcl(scalar), str) else "'"
    return dumper.represent_scalar('tag:yaml.org,2002:str', scalar, style=style)


_Dumper.add_representer(str, _represent_text)


def _described(value: object) -> str:
    """Return a value with its type, for messages."""
    return f'the text {shortened(value, 60)!r}' if isinstance(value, str) else str(value)


def as_rcl(scalar: str) -> bool | int | float | str:
    """
    Return the value that rcl reads for a text without quotes.

    Examples
    --------
    >>> as_rcl('y'), as_rcl('017'), as_rcl('1e-3'), as_rcl('1_0')
    (True, 15, 0.001, '1_0')

    """
    if scalar in _WORDS:
        return _WORDS[scalar]
    whole = _whole_number(scalar) if _INTEGER.fullmatch(scalar) else None
    return _real_number(scalar) if whole is None else whole


def _whole_number(scalar: str) -> int | float | None:
    """Return the number that C's strtol reads in base 0, a float beyond 64 bits; None if digits do not fit the base."""
    sign, digits = (-1 if scalar[0] == '-' else 1), scalar.lstrip('+-').lower()
    base = 16 if digits.startswith('0x') else 8 if digits.startswith('0') else 10
    if base == 8 and {'8', '9'} & set(digits):
        return None
    whole = sign * int(digits, base)
    return whole if -2**63 <= whole < 2**63 else float(whole if base == 16 else scalar)


def _real_number(scalar: str) -> float | str:
    """Return the number that C's strtod reads; the text if there is none, or after an overflow or underflow."""
    number, mantissa = 0.0, ''
    if _NOT_FINITE.fullmatch(scalar):
        return float(scalar.replace('.', '').partition('(')[0])
    if _FLOAT.fullmatch(scalar):
        number, mantissa = float(scalar), re.split('[eE]', scalar)[0]
    elif _HEXADECIMAL.fullmatch(scalar):
        with suppress(OverflowError):
            return float.fromhex(scalar)
    exact = _NORMAL <= abs(number) < float('inf') or (mantissa and not set(mantissa) & set('123456789'))
    return number if exact else scalar


def parse_yaml(document: str, source: str) -> Any:
    """Read YAML; raise ParameterError with source and line if it is not YAML, or rcl would read it differently."""
    try:
        loader = _Loader(document)
        try:
            node = loader.get_single_node()
            return None if node is None else loader.value(node)
        finally:
            loader.dispose()
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # a ValueError for a date such as 2001-99-99
        mark = getattr(error, 'problem_mark', None)
        where = f', line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or 'not valid YAML'
        remedy = '' if isinstance(error, _Refused) else '; it must be a ROS 2 parameter file'
        raise ParameterError([f'{source}{where}: {problem}{remedy}']) from error


def dump_yaml(tree: object, width: float | None = None) -> str:
    """
    Write mappings, lists, texts and numbers as YAML that reads back the same, numbers to the last bit.

    Lines are broken at `width` characters, by default at 80.
    """
    return str(yaml.dump(tree, Dumper=_Dumper, sort_keys=False, default_flow_style=None, width=width))
