"""The tables of the loop's topics in docs/topics.md and on the nodes' pages, from the rows of the topics."""

import sys
from collections.abc import Iterator

from page_part import PagePart, table_row

from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.topics import LOOPS, TOPICS


def _lines(head: tuple[str, ...], rows: Iterator[tuple[str, ...]]) -> list[str]:
    """Return a table in Markdown."""
    return list(map(table_row, [head, ['---'] * len(head), *rows]))


def _all() -> Iterator[tuple[str, ...]]:
    for topic in TOPICS.values():
        yield (f'`{topic.name}`', f'`{topic.kind}`', topic.meaning, topic.publisher,
               ', '.join(topic.subscribers) or 'none', topic.rate.replace('_', ' '))


def _of(node: str) -> Iterator[tuple[str, ...]]:
    """Yield the topics that a node always has, its inputs first."""
    topics = [*LOOPS['torque'].topics.values(), *LOOPS['torque'].recorded.values()]
    for verb, found in (('subscribes', [topic for topic in topics if node in topic.subscribers]),
                        ('publishes', [topic for topic in topics if topic.publisher == node])):
        yield from ((f'`{topic.name}`', f'`{topic.kind}`', verb) for topic in found)


def parts() -> dict[str, tuple[PagePart, str]]:
    """Return the part of each page by its file, with its marks."""
    lines = {'docs/topics.md': ('table of topics', _lines(
        ('topic', 'type', 'fields', 'publisher', 'subscribers', 'rate'), _all()))}
    lines |= {f'docs/nodes/{node}.md': (f'topics of {node}', _lines(('topic of the loop', 'type', ''), _of(node)))
              for node in NODES}
    return {file: (PagePart(name), PagePart(name).marked('topics.py', made)) for file, (name, made) in lines.items()}


if __name__ == '__main__':
    made = parts()
    for file in sys.argv[1:]:
        part, text = made[file]
        part.write([file], text)
