"""YAML as rcl reads and writes it."""

import re
from typing import Any

import yaml

from mobile_robot_control.parameters.checking import ParameterError


class _Loader(yaml.SafeLoader):
    """YAML as rcl reads it: 1e-3 is a number, though YAML 1.1 wants 1.0e-3."""


class _Dumper(yaml.SafeDumper):
    """YAML for the loader: a text such as '1e-3' needs quotes."""


for _side in (_Loader, _Dumper):
    _side.add_implicit_resolver(
        'tag:yaml.org,2002:float',
        re.compile(r'^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$'),
        list('-+0123456789.'),
    )


def parse_yaml(text: str, source: str) -> Any:
    """Read YAML; raise ParameterError with the source and the line if it is not YAML."""
    try:
        return yaml.load(text, _Loader)  # noqa: S506 (a SafeLoader)
    except (yaml.YAMLError, ValueError) as error:  # a ValueError for a date such as 2001-99-99
        mark = getattr(error, 'problem_mark', None)
        where = f', line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or 'not valid YAML'
        raise ParameterError([f'{source}{where}: {problem}; it must be a ROS 2 parameter file']) from error


def dump_yaml(tree: Any) -> str:
    """Write mappings, lists, texts and numbers as YAML that reads back the same, numbers to the last bit."""
    return str(yaml.dump(tree, Dumper=_Dumper, sort_keys=False, default_flow_style=None))
