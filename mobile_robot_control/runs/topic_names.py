"""The names of the loop's topics in a bag, as options give them."""

import re
from collections.abc import Sequence
from typing import Annotated, Any

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.parameters.requests import Reader
from mobile_robot_control.runs.bag import NAMES

_TOPIC = re.compile(r'/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*', re.ASCII)


def _read_topic(value: Any) -> tuple[str, str]:
    """Read NAME:=TOPIC, or a pair of them."""
    name, separator, topic = value.partition(':=') if isinstance(value, str) else (value[0], ':=', value[1])
    if not separator:
        raise ValueError('write NAME:=TOPIC, such as odom:=/base/odom')
    if name not in NAMES:
        raise ValueError(f"'{name}' is no topic of the loop; take one of {', '.join(NAMES)}")
    if not _TOPIC.fullmatch(topic):
        raise ValueError(f"'{topic}' is no name of a topic; write one such as /base/odom")
    return name, topic


Topics = Annotated[tuple[tuple[str, str], ...], Field(
    '', 'name of a loop topic, or of ground_truth, on your robot or in your bags, such as odom:=/base/odom; may be '
    'repeated'),
    Reader(_read_topic, 'NAME:=TOPIC', again=True)]
"""The option --topic."""


def topic_names(pairs: Sequence[tuple[str, str]]) -> dict[str, str]:
    """Return topic names in a bag by those of the loop; raise ParameterError if one occurs twice."""
    chosen: dict[str, str] = {}
    for name, topic in pairs:
        if chosen.get(name, topic) != topic:
            raise ParameterError([f"--topic '{name}:={topic}': {name} is {chosen[name]} already; name each topic once"])
        if topic in [other for known, other in chosen.items() if known != name]:
            raise ParameterError([f"--topic '{name}:={topic}': {topic} is taken already; name each topic once"])
        chosen[name] = topic
    return chosen
