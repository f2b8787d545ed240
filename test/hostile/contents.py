"""Odd files: spoilt ones of every format, and paths that are no files."""

import json
import os
import shutil
import socket
import struct
import zlib
from pathlib import Path

from hostile.words import NAMES, NUMBERS, mangled

_LARGE = 1 << 31


def spoilt_bytes(draw, content):
    """Spoil a file: cut it, change bytes, repeat or insert some, in several places."""
    content = bytearray(content)
    for _ in range(draw.choice((1, 1, 1, 2, 5, 50))):
        place = draw.randrange(len(content) + 1)
        how = draw.randrange(6)
        if how == 0:
            del content[place:]
        elif how == 1:
            del content[place:place + draw.choice((1, 4, 100))]
        elif how == 2:
            content[place:place + 1] = bytes([draw.randrange(256)])
        elif how == 3:
            content[place:place + 8] = draw.choice((b'\xff' * 8, bytes(8), struct.pack('<Q', 1 << draw.randrange(64))))
        elif how == 4:
            content[place:place] = draw.randbytes(draw.choice((1, 10, 1000)))
        else:
            content[place:place] = content[max(0, place - draw.choice((10, 500))):place]
    return bytes(content)


def spoilt_text(draw, content):
    """Spoil a text: mangled in some places, or its bytes spoilt."""
    if draw.random() < 0.3:
        return spoilt_bytes(draw, content.encode(errors='surrogatepass'))
    for _ in range(draw.choice((1, 1, 2, 10))):
        content = mangled(draw, content)
    return content.encode(errors='surrogateescape' if draw.random() < 0.5 else 'replace')


def odd_json(draw, depth=0):
    """Draw a JSON text, or nearly one."""
    kinds = [lambda: draw.choice(NUMBERS[:60]), lambda: json.dumps(draw.choice(NAMES)), lambda: 'null', lambda: 'NaN',
             lambda: '[' * 100_000,
             lambda: f'[{",".join(odd_json(draw, depth + 1) for _ in range(draw.randrange(4)))}]',
             lambda: '{' + ','.join(f'{json.dumps(draw.choice(NAMES))}: {odd_json(draw, depth + 1)}'
                                    for _ in range(draw.randrange(4))) + '}']
    return draw.choice(kinds if depth < 3 else kinds[:4])()


def odd_yaml(draw, sound):
    """Draw YAML: a sound file spoilt, values replaced, or of no use at all."""
    lines = sound.splitlines()
    for _ in range(draw.choice((1, 1, 2, 5))):
        n = draw.randrange(len(lines))
        indented = lines[n][:len(lines[n]) - len(lines[n].lstrip())]
        name = lines[n].strip().partition(':')[0]
        lines[n] = draw.choice((
            f'{indented}{name}: {draw.choice(NUMBERS)}', f'{indented}{draw.choice(NAMES)}: 1.0', f'{indented}? {name}',
            f'{indented}- {name}', f'{indented}{name}: &a {draw.choice(NUMBERS)}', f'{indented}<<: *a', f'\t{lines[n]}',
            f'{indented}{name}: |', f'{indented}{name}: {{', f'{lines[n]}\n{lines[n]}', '---', '%YAML 1.3', '...',
            f'{indented}{name}: !!python/name:os.system', f'{indented}{name}: {"[" * 2000}', f'{indented}{name}: "\\0"',
            f'{indented}{name}: "\\ud800"', mangled(draw, lines[n]),
        ))
    return '\n'.join(lines)


_LAUGHS = 'a: &a0 [x]\n' + ''.join(f'b{n}: &a{n + 1} [{", ".join([f"*a{n}"] * 9)}]\n' for n in range(12))
WHOLE = {'empty': lambda: b'', 'a zero byte': lambda: b'\0', 'random bytes': lambda: bytes(range(256)) * 40,
         'a byte order mark': lambda: b'\xef\xbb\xbf', 'UTF-16': lambda: 'a: 1'.encode('utf-16'),
         'no end of line': lambda: b'a' * 900_000, 'references to references': _LAUGHS.encode,
         'brackets': lambda: b'[' * 500_000, 'braces': lambda: b'{a: ' * 100_000, 'lines': lambda: b'\n' * 900_000,
         'a checksum': lambda: b'%08x 1\n' % zlib.crc32(b'1'),
         'an SQLite head': lambda: b'SQLite format 3\0' + bytes(4096),
         'an mcap head': lambda: b'\x89MCAP0\r\n' + b'\xff' * 90}
"""Contents that fit no format."""


def _socket(path):
    with socket.socket(socket.AF_UNIX) as made:
        before = os.getcwd()
        # the address of a socket has at most 107 characters
        os.chdir(path.parent)
        made.bind(path.name)
        os.chdir(before)


def _large(path):
    path.touch()
    os.truncate(path, _LARGE)


def _unreadable(path):
    path.write_text('a')
    path.chmod(0)


def _below_a_file(path):
    path.parent.joinpath('file').write_text('')
    path.symlink_to('file/below')


SPECIAL = {
    'absent': lambda path: None, 'folder': Path.mkdir, 'pipe': os.mkfifo, 'socket': _socket, 'large': _large,
    'unreadable': _unreadable, 'link to itself': lambda path: path.symlink_to(path.name),
    'dangling link': lambda path: path.symlink_to('absent'), 'link to a folder': lambda path: path.symlink_to('.'),
    'below a file': _below_a_file,
    **{f'link to {device}': lambda path, device=device: path.symlink_to(device) for device in (
        '/dev/zero', '/dev/full', '/dev/null', '/dev/stdin', '/proc/self/mem', '/proc/self/environ',
        '/proc/self/maps', '/proc')},
}
"""What a path may be other than a file, by what it is; each is made by a function of the path."""
PATHS = ['/dev/zero', '/dev/full', '/dev/null', '/dev/random', '/dev/stdin', '/dev/fd/0', '/proc/self/mem',
         '/proc/self/environ', '/proc/1/mem', '/', '.', '..', '', ' ', '~', '\n', 'a' * 300, 'a/' * 3000,
         '/proc/self/cwd', '\udcff', 'x/../..', '-']
"""Paths as they are."""


def odd_path(draw, place, name):
    """Make what is no sound file, with one of several contents, or draw a path; returns it."""
    chance = draw.random()
    if chance < 0.3:
        return draw.choice(PATHS)
    path = place.here / name
    if chance < 0.65:
        SPECIAL[draw.choice(list(SPECIAL))](path)
    else:
        path.write_bytes(WHOLE[draw.choice(list(WHOLE))]())
    return str(path)


def spoilt_bag(draw, place):
    """Copy the sound bag and spoil one of its files; returns its path."""
    bag = place.here / 'bag'
    shutil.copytree(place.samples / 'bag', bag)
    file = draw.choice(sorted(bag.iterdir()))
    if draw.random() < 0.2:
        file.unlink()
        SPECIAL[draw.choice(list(SPECIAL))](file)
    else:
        file.write_bytes(spoilt_bytes(draw, file.read_bytes()))
    return str(bag)


def spoilt_journal(draw, place):
    """Copy the sound journal with one line of odd JSON and its right checksum, or spoilt bytes; returns the output."""
    journal = place.out / 'search.yaml.journal'
    content = (place.samples / 'search.yaml.journal').read_bytes()
    if draw.random() < 0.5:
        lines = content.splitlines(keepends=True)
        text = odd_json(draw).encode()
        lines[draw.randrange(len(lines))] = b'%08x %s\n' % (zlib.crc32(text), text)
        content = b''.join(lines)
    else:
        content = spoilt_bytes(draw, content)
    journal.write_bytes(content)
    return str(place.out / 'search.yaml')
