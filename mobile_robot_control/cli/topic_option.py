"""The option `--topic` of commands that read bags: other names of the loop's topics."""

import argparse
import re
from collections.abc import Sequence
from typing import Any

from mobile_robot_control.recording.bag_topics import NAMES

_TOPIC = re.compile(r'/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*', re.ASCII)


class TopicNames(argparse.Action):
    """Collects NAME:=TOPIC, given again and again, into a dict; bad usage where a name is none of the loop's."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        """Add one NAME:=TOPIC."""
        text = str(values)
        name, separator, topic = text.partition(':=')
        if not separator:
            parser.error(f"{option_string} '{text}': write NAME:=TOPIC, such as odom:=/base/odom")
        if name not in NAMES:
            parser.error(f"{option_string} '{text}': '{name}' is no topic of the loop; take one of {', '.join(NAMES)}")
        if not _TOPIC.fullmatch(topic):
            parser.error(f"{option_string} '{text}': '{topic}' is no name of a topic; write one such as /base/odom")
        chosen = dict(getattr(namespace, self.dest))
        if chosen.get(name, topic) != topic:
            parser.error(f"{option_string} '{text}': {name} is {chosen[name]} already; name each topic once")
        if topic in [other for known, other in chosen.items() if known != name]:
            parser.error(f"{option_string} '{text}': {topic} is taken already; name each topic once")
        setattr(namespace, self.dest, {**chosen, name: topic})
