"""The README is short, and what it shows exists."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
README = (ROOT / 'README.md').read_text(encoding='utf-8')
ACTIVATE = '. .venv/bin/activate'
COMMANDS = ('simulate ', 'experiment ', 'report ', 'tune ', 'study ', 'dashboard ', 'plant ', 'velocity_controller ')


def test_it_has_at_most_120_lines():
    assert len(README.splitlines()) <= 120


def test_the_pictures_exist():
    pictures = re.findall(r'!\[[^]]*]\(([^)]+)\)', README)
    assert any(picture.endswith('.gif') for picture in pictures)
    for picture in pictures:
        assert (ROOT / picture).is_file()


def test_the_environment_is_activated_before_its_first_command():
    lines = README.splitlines()
    assert lines.index(ACTIVATE) < min(n for n, line in enumerate(lines) if line.startswith(COMMANDS))


def test_beside_each_ros2_command_stands_what_works_without_ros2():
    rows = [line.split('|')[1:-1] for line in README.splitlines() if line.startswith('|') and '`ros2 ' in line]
    assert rows
    assert len(rows) == sum('`ros2 ' in line for line in README.splitlines())
    for with_ros2, without in rows:
        assert '`ros2 ' in with_ros2
        assert '`' in without
        assert 'ros2' not in without
