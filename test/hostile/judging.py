"""The one rule, which every case keeps; see docs/robustness.md."""

import os
import re
import signal

from mobile_robot_control.system.texts import printable

LARGEST_MEMORY = 1000
"""[MB]."""
_ENDS = re.compile(r'Traceback \(most recent call last\)|Fatal Python error|Segmentation fault|core dumped|^\w*Error: ',
                   re.MULTILINE)
_OF_RCL = re.compile(r'^\[[A-Z]+\] \[\d.*$', re.MULTILINE)
"""What rcl logs before the node exists."""
_FAILED = ('diverged', 'interrupted', 'failed', 'could be scored', 'time limit is too short', 'and stays',
           'gave no answer', 'is no report', 'ended with exit code', 'stands still')
"""What a run that has failed, with exit code 1, is told to have done, where no value is at fault."""


def _numbers(text):
    try:
        number = float(text)
    except ValueError:
        return []
    return [f'{number:g}', repr(number), str(number)]


def spellings(value):
    """Return how a message may write a value: as it is or printable, cut off, quoted, or as a number."""
    shown = printable(value)
    # a path has no slash at its end
    base = os.path.basename(shown.rstrip('/'))[:40]
    return [word for word in (value, shown, shown[:20], repr(value)[1:-1], shown.replace("'", "\\'"), base,
                              *_numbers(value)) if word] or ["''", '.', ': : ']


def names_one(printed, values):
    """Return whether one of several values is named, in any spelling."""
    # a message may name the file that a link leads to
    printed = re.sub(r'/proc/\d+', '/proc/self', printed)
    values = [*values, *(os.path.realpath(value) for value in values if value.startswith('/'))]
    return any(word in printed for value in values for word in spellings(value))


def faults(case, answer, printed, before, after):
    """List how a case breaks the rule, by the arena's answer, the standard error and the `listing` of its place."""
    code, found = answer['code'], []
    # an interrupt may come before the handlers are installed, or when Python has removed them
    if code not in ((0, 1, 2, -signal.SIGINT) if answer['sent'] else (0, 1, 2)):
        found.append(f'exit code {code}')
    if len(answer['sent']) > 1:
        found.append('hangs: neither ended by itself nor by SIGINT')
    if _ENDS.search(printed):
        found.append('a traceback or a crash')
    failed = code == 1 and any(word in printed for word in _FAILED)
    if code in (1, 2) and not names_one(printed, case.named) and not failed:
        found.append(f'exit code {code}, and none of {case.named} is named')
    if odd := sorted({letter for letter in _OF_RCL.sub('', printed) if not letter.isprintable()} - set('\n\r\t')):
        found.append(f'characters that cannot be shown: {odd}')
    if answer['left']:
        found.append(f'processes left: {answer["left"]}')
    if answer['memory'] > LARGEST_MEMORY:
        found.append(f'{answer["memory"]} MB of memory')
    changed = sorted(path for path in {*before, *after} if before.get(path) != after.get(path))
    if changed:
        found.append(f'written outside of --output: {changed}')
    return found
