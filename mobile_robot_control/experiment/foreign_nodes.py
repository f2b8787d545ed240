"""Nodes of somebody else in the places of ours: a command that an experiment starts, or a node that runs already."""

import hashlib
import shlex
import shutil
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.system.files import METRICS, parse_json, read_bounded
from mobile_robot_control.system.texts import printable, shortened
from mobile_robot_control.topics import LoopGraph


class ForeignNode(NamedTuple):
    """
    A node that is not of this package.

    Attributes
    ----------
    words : tuple of str
        Its command; empty for a node that runs already.
    sha256 : str
        Of the words, and of the files that they name; '' for a node that runs already.

    """

    words: tuple[str, ...] = ()
    sha256: str = ''

    @property
    def is_attached(self) -> bool:
        """Whether it runs already, and is not started."""
        return not self.words

    @property
    def record(self) -> dict[str, Any]:
        """As in a provenance."""
        return {'attached': True} if self.is_attached else {'command': shlex.join(self.words), 'sha256': self.sha256}


def read_name(value: Any) -> str:
    """Return the name of one of the four nodes; raise ValueError for another."""
    if value not in NODES:
        raise ValueError(f"'{value}' is none of the nodes; take one of {', '.join(NODES)}")
    return str(value)


def read_command(value: Any, example: str = 'position_controller') -> tuple[str, tuple[str, ...]]:
    """Read NAME=COMMAND into any name and the command's words; raise ValueError with a remedy."""
    name, separator, command = value.partition('=')
    try:
        words = tuple(shlex.split(command))
    except ValueError as error:
        raise ValueError(f'{error}: close the quotation marks of the command') from None
    if not separator or not words:
        raise ValueError(f"write NAME=COMMAND, such as {example}='python my_node.py'")
    return name, words


def read_node(value: Any) -> tuple[str, tuple[str, ...]]:
    """Read NAME=COMMAND with the name of one of the four nodes."""
    name, words = read_command(value)
    return read_name(name), words


def missing_program(name: str, words: Sequence[str]) -> list[str]:
    """Return what is wrong with the program of a command; [] if it is there."""
    return [] if shutil.which(words[0]) else [
        f"--node {name}: there is no program '{printable(words[0])}'; write its path, or install it"]


def started_node(words: tuple[str, ...]) -> ForeignNode:
    """Return the node of a command."""
    return ForeignNode(words, _checksum(words))


def foreign_nodes(
    commands: Sequence[tuple[str, tuple[str, ...]]], attached: Sequence[str], loop: LoopGraph
) -> dict[str, ForeignNode]:
    """Return the nodes of somebody else by name; raise ParameterError for what cannot be in this loop."""
    names = [*(name for name, _ in commands), *attached]
    faults = [f'{name} is given twice; name each node once, with --node or with --attach'
              for name in sorted({name for name in names if names.count(name) > 1})]
    faults += [f'{name} is no node of a loop with plant.drive = velocity; its nodes are {", ".join(loop.nodes)}'
               for name in names if name not in loop.nodes]
    faults += [fault for name, words in commands for fault in missing_program(name, words)]
    if faults:
        raise ParameterError(faults)
    return {**{name: started_node(words) for name, words in commands},
            **dict.fromkeys(attached, ForeignNode())}


def _checksum(words: Sequence[str]) -> str:
    digest = hashlib.sha256('\0'.join(words).encode(errors='surrogateescape'))
    for word in words:
        path = Path(word)
        # a program that is found on PATH is one of the machine, such as python
        if path.is_file():
            with path.open('rb') as file:
                while block := file.read(1 << 20):
                    digest.update(block)
    return digest.hexdigest()


def recorded_nodes(folder: Path) -> dict[str, Any]:
    """Return what the folder of an experiment records of nodes of somebody else; {} where all were ours."""
    try:
        nodes = parse_json(read_bounded(folder / 'metrics.json', METRICS))['provenance']['nodes']
    except (OSError, ValueError, KeyError, TypeError):
        return {}
    return nodes if isinstance(nodes, dict) else {}


def replay_faults(recorded: Mapping[str, Any], chosen: Mapping[str, ForeignNode]) -> list[str]:
    """Return why a run with the recorded nodes is not repeated by the chosen ones."""
    present = {name: node.record for name, node in chosen.items()}
    faults = []
    for name in sorted({*recorded, *present}):
        before, now = recorded.get(name), present.get(name)
        if isinstance(before, dict) and before.get('attached'):
            faults.append(f'{name} was a node that ran already, which no replay can start again')
        elif before is None:
            faults.append(f'{name} was the node of this package; leave --node {name}=... out')
        elif not isinstance(before, dict) or now is None or any(
                before.get(key) != now.get(key) for key in ('command', 'sha256')):
            command = shortened(printable(str(before.get('command'))), 200) if isinstance(before, dict) else '?'
            digest = str(before.get('sha256'))[:12] if isinstance(before, dict) else '?'
            faults.append(f'{name} was the command {command} (SHA-256 {digest}...)' + (
                ', and it or a file of it is another one now; bring that back' if now
                else f'; add --node {shlex.quote(f"{name}={command}")}'))
    return faults


def ours(loop: LoopGraph, foreign: Collection[str]) -> list[str]:
    """List the nodes of this package in a loop, in its order."""
    return [name for name in loop.nodes if name not in foreign]
