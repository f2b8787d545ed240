"""
The commands of the README and of the pages run as printed, in order, from a clean folder with config/, examples/,
test/plugins/ and the published table of the benchmark.

What needs `ros2`, make, git or a desktop is not run: its executables, targets, parameters and files are checked. Long
commands get the options of SHORTER, each of which the page itself names. Without the long tests (make soak) the README
alone runs, without SLOW.
"""

import contextlib
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.topics import EVENTS, LOOP_TOPICS, OTHER_INPUTS

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *(ROOT / 'docs').rglob('*.md'),
                *(ROOT / 'examples').rglob('*.md')])
FENCE = re.compile(r'^```(\S*)\n(.*?)^```$', re.DOTALL | re.MULTILINE)
COMMANDS = {'simulate', 'experiment', 'report', 'tune', 'study', 'benchmark', 'plan', 'excite', 'identify'}
ELSEWHERE = {'ros2', 'plotjuggler', 'rviz2', 'colcon', 'rosdep', 'make', 'diff', 'git', 'PYTHONPATH=.',
             'dashboard'}
"""First words of what is not run."""
OWN = ('base.yaml', 'runs/dwb_1')
"""What a reader has: a command that needs it is not run."""
SLOW = {'tune', 'study', 'benchmark', *NODES, 'kill'}
"""What runs with the long tests alone."""
SHORTER = {
    'tune': '--generations 2', 'study': '--runs 20', 'benchmark': '--budgets 25 --scenarios 1 --runs 2',
    'experiment': '-p plant.real_time_factor:=0.0',
    'plant': '-p real_time_factor:=0.0', ('README.md', 'experiment'): '-p plant.real_time_factor:=0.0 --composed '
    '--no-report', ('docs/own_robot.md', 'experiment'): '--duration 4',
    ('docs/benchmark.md', 'benchmark'): '--budgets 25 --scenarios 1 --runs 2 --seeds 1 2',
    # of a map, whose runs fill a square
    ('docs/results.md', 'study'): '--runs 4',
    ('docs/own_robot.md', 'excite'): '--duration 20', ('docs/own_robot.md', 'plant'): '',
    ('docs/extending.md', 'experiment'): '-p plant.real_time_factor:=0.0 --duration 4',
}
"""Options for a command, or for one of a page."""


def _name(path):
    return str(path.relative_to(ROOT))


def blocks(text):
    """The kind and the content of each fenced block that runs."""
    return [(kind, content) for kind, content in FENCE.findall(text) if kind in ('sh', 'bash', 'python')]


def commands(content):
    """The commands of a shell block: with continued lines and here-documents, without comments."""
    lines = iter(content.splitlines())
    for line in lines:
        command = line
        while command.endswith('\\'):
            command += '\n' + next(lines)
        here = re.search(r"<<'(\w+)'$", command)
        while here and command.rpartition('\n')[2] != here[1]:
            command += '\n' + next(lines)
        if not here:
            command = re.sub(r'(^|\s+)#.*$', '', command)
        if command.strip():
            yield command


def first_word(command):
    """The program of a command, or what `mrc` runs."""
    words = command.split()
    name = Path(words[0]).name if '/bin/' in words[0] else words[0]
    return words[1] if name == 'mrc' else name


def shortened(page, text, command):
    """The command with the options that make it short; each of them stands in the page."""
    word = first_word(command)
    # against a table a node alone can be shortened
    options = ('--node-runs 1' if '--node ' in command and word == 'benchmark' else
               '' if '--against' in command else SHORTER.get((page, word), SHORTER.get(word, '')))
    wanted = [option for option in re.split(r' (?=-)', options)
              if option and not re.search(rf'{re.escape(option)}(?!\S| +[^- ])', command)]
    for option in wanted:
        assert option in text, f'{page}: {option} shortens {word} in the tests, and the page does not name it'
    start, background, _ = command.partition(' &')
    return ' '.join([start, *wanted]) + background


def files_of(command):
    """Check what does not run; return the files that it needs."""
    words = shlex.split(command, comments=True)
    for arguments in re.findall(r'\bmake ([^)#]*)', command):
        target = re.sub(r'-C \S+|-\w+|\w+=\S+', '', arguments).split()
        makefile = (ROOT / 'Makefile').read_text(encoding='utf-8')
        assert all(re.search(rf'^{name}:', makefile, re.MULTILINE) for name in target), command
    if words[:3] == ['ros2', 'run', 'mobile_robot_control']:
        assert words[3] in {*NODES, *COMMANDS}, command
    if words[:3] == ['ros2', 'launch', 'mobile_robot_control']:
        assert (ROOT / 'launch' / words[3]).is_file(), command
    if words[:3] == ['ros2', 'param', 'set']:
        assert declarations(NODES[words[3].strip('/')])[words[4]].field.live, command
    if words[:2] == ['ros2', 'topic']:
        topic = next((word for word in words[3:] if word.startswith('/')), '')
        assert topic.strip('/') in {*LOOP_TOPICS, *OTHER_INPUTS, EVENTS, 'diagnostics'}, command
    found = [words[n + 1] for n, word in enumerate(words[:-1]) if word in ('--params-file', '--layout', '-d')]
    found += [word.removeprefix('params:=') for word in words if re.search(r'^params:=|\.(?:urdf|py)$', word)]
    return [file for file in found if file not in ('FILE', 'my_robot.yaml', *OWN)]


def script(path, skipped=frozenset()):
    """The bash script of a page."""
    text = path.read_text(encoding='utf-8')
    lines = ['set -e -o pipefail', """trap 'echo "failed: $BASH_COMMAND" >&2' ERR"""]
    for kind, content in blocks(text):
        if kind == 'python':
            lines.append(f"python - <<'END_OF_BLOCK'\n{content}END_OF_BLOCK")
            continue
        for command in commands(content):
            if first_word(command) in ELSEWHERE or any(own in command for own in OWN):
                lines += [f'test -e {shlex.quote(file)} || test -e {shlex.quote(str(ROOT / file))}'
                          for file in files_of(command)]
            elif first_word(command) not in skipped:
                lines.append(shortened(_name(path), text, command))
    return '\n'.join(lines) + '\n'


def _run(text, folder, timeout):
    """Run a script in a clean folder that has parameter files, examples, the plugins of the tests, this environment."""
    for name in ('config', 'examples', 'test/plugins'):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns('__pycache__'))
    (folder / 'docs').mkdir()
    shutil.copy(ROOT / 'docs' / 'benchmark_table.json.gz', folder / 'docs')
    (folder / '.venv').symlink_to(sys.prefix)
    paths = [str(ROOT / 'test'), os.environ.get('PYTHONPATH', '')]
    environment = os.environ | {'PATH': f'{sys.prefix}/bin:{os.environ["PATH"]}',
                                'PYTHONPATH': os.pathsep.join(filter(None, paths))}
    process = subprocess.Popen(['bash', '-c', text], cwd=folder, env=environment, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, start_new_session=True)
    try:
        output, _ = process.communicate(timeout=timeout)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == 0, output[-3000:]


@pytest.mark.long
def test_the_readmes_commands_run(domain, tmp_path):
    _run(script(ROOT / 'README.md', SLOW), tmp_path, 280)


@pytest.mark.soak
@pytest.mark.timeout(600)
@pytest.mark.parametrize('path', [path for path in PAGES if blocks(path.read_text(encoding='utf-8'))], ids=_name)
def test_every_command_of_a_page_runs(domain, path, tmp_path):
    _run(script(path), tmp_path, 580)


@pytest.mark.parametrize('path', PAGES, ids=_name)
def test_what_does_not_run_exists(path):
    """Also the `ros2` commands within the text."""
    script(path)
    for command in re.findall(r'`(ros2 [^`]+)`', FENCE.sub('', path.read_text(encoding='utf-8'))):
        if len(command.split()) > 3 and 'NAME' not in command:
            assert all((ROOT / file).exists() for file in files_of(command)), command


def test_every_command_is_one_that_is_known_and_none_hides_in_a_block_that_does_not_run():
    """A new kind of command is run knowingly, or listed in ELSEWHERE."""
    known = COMMANDS | ELSEWHERE | set(NODES) | {'.', 'cat', 'cp', 'export', 'kill', 'pip', 'printf', 'python', 'sleep'}
    for path in PAGES:
        for kind, content in FENCE.findall(path.read_text(encoding='utf-8')):
            if kind in ('sh', 'bash'):
                assert {first_word(command) for command in commands(content)} <= known, _name(path)
            elif kind in ('', 'text'):
                assert not {line.split()[0] for line in content.splitlines() if line.strip()} & (
                    COMMANDS | ELSEWHERE | {'mrc', 'python', 'pip', 'cp'}), _name(path)


def test_commands_are_read_with_what_continues_them():
    page = 'Text.\n\n```sh\nmrc simulate --duration 0.01 --params-file \\\n  nowhere.yaml   # a comment\n```\n'
    (kind, content), = blocks(page)
    command, = commands(content)
    assert (kind, command) == ('sh', 'mrc simulate --duration 0.01 --params-file \\\n  nowhere.yaml')
    content = "cat > a.yaml <<'END'\nrun: true   # kept\nEND\nkill $(jobs -p)     # ends it\n"
    assert list(commands(content)) == ["cat > a.yaml <<'END'\nrun: true   # kept\nEND", 'kill $(jobs -p)']


def test_a_command_that_fails_is_found(tmp_path):
    with pytest.raises(AssertionError, match=r'nowhere\.yaml: cannot be read'):
        _run('set -e\nmrc simulate --duration 0.01 --params-file \\\n  nowhere.yaml\ntrue\n', tmp_path, 60)


def test_a_command_that_does_not_exist_is_found():
    for absent in ('make no_such_target', 'ros2 run mobile_robot_control no_such_node',
                   'ros2 param set /plant duration 3.0', 'ros2 topic echo /no_such_topic',
                   'ros2 launch mobile_robot_control no_such.launch.xml'):
        with pytest.raises(AssertionError, match=re.escape(absent)):
            files_of(absent)
