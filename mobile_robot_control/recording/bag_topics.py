"""Which topics of a bag are those of the loop, and what to say where they are not."""

from collections.abc import Collection, Iterator, Mapping, Set
from pathlib import Path

from mobile_robot_control.recording.bag_files import BagFiles
from mobile_robot_control.recording.columns import GROUND_TRUTH
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import LOOP_TOPICS

NAMES = (*LOOP_TOPICS, GROUND_TRUTH)
"""Topics that a bag is searched for."""


def held_topics(path: Path) -> set[str]:
    """Return the absolute names of all topics of a bag; raise BagError if it is none."""
    bag = BagFiles(path, lambda *_: None)
    for _ in bag.messages(lambda _: False):
        pass
    return bag.topics


def choose_topics(namespace: str, topics: Mapping[str, str], held: Set[str]) -> tuple[dict[str, str], list[str]]:
    """
    Choose the topics of a bag.

    Parameters
    ----------
    namespace : str
        In which the nodes ran; relative names are in it.
    topics : mapping of str to str
        The other names of some of NAMES.
    held : set of str
        Absolute names of the bag's topics; needed where there are other names.

    Returns
    -------
    tuple of dict of str to str, and list of str
        The loop's name of each topic by its name in the bag, and what the bag lacks, in words.
    """
    prefix = namespace.rstrip('/') + '/'
    chosen, problems = {prefix + name: name for name in NAMES}, []
    for name, given in topics.items():
        other = given if given.startswith('/') else prefix + given
        if other in held:
            del chosen[prefix + name]
            chosen[other] = name
        else:
            instead = f'{prefix + name} is taken' if prefix + name in held else f'it holds {_listed(held)}'
            problems.append(f'--topic {name}:={given}: the bag has no {other}; {instead}')
    return chosen, problems


def missing_topics(names: Mapping[str, str], silent: Collection[str], held: Set[str]) -> Iterator[str]:
    """Yield what to name where a bag has no odometry or no reference under the names that were looked for."""
    loop = [topic for topic, name in names.items() if name != GROUND_TRUTH]
    if not any(topic in held for topic in loop):
        yield (f'none of the topics {", ".join(loop)}; the bag holds {_listed(held)}: name the robot with --namespace, '
               'or its topics with --topic odom:=/NAME')
    elif lacking := [name for name in ('odom', 'reference') if name in silent]:
        yield (f'the bag holds {_listed(held)}: where one of them is '
               f'{" or ".join(lacking)}, add --topic {lacking[0]}:=/NAME')


def _listed(held: Set[str]) -> str:
    """Return the names of topics in one line."""
    return shortened(', '.join(sorted(map(str, held)))) or 'nothing'
