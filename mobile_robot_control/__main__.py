"""
The command `mrc`, also `python -m mobile_robot_control`: every command and node of the package by its name.

Under ROS 2 they are executables of their own: ``ros2 run mobile_robot_control NAME``.
"""

import ast
import inspect
import sys
from importlib import import_module
from pathlib import Path

NODES = ('plant', 'velocity_controller', 'position_controller', 'reference_cart')
COMMANDS = {
    'simulate': 'runs', 'experiment': 'experiment', 'report': 'report', 'tune': 'search', 'study': 'studying',
    'benchmark': 'benchmarking', 'plan': 'planning', 'excite': 'excitation', 'identify': 'identification',
    'dashboard': 'dashboard',
}
"""The folder of each command, whose `command.py` has its `main`."""
_COMPLETION = """\
[ -n "$ZSH_VERSION" ] && autoload -U +X bashcompinit && bashcompinit
_mrc() {{ [ "$COMP_CWORD" = 1 ] && COMPREPLY=($(compgen -W "{names}" -- "${{COMP_WORDS[1]}}")); }}
complete -o default -F _mrc mrc
"""
_HELP = """\
usage: mrc NAME ...

commands, each with --help:
{commands}

nodes, each with --ros-args ...:
  {nodes}

  --version     the version of the package
  --completion  what completes these names in bash and zsh: eval "$(mrc --completion)"
"""


def _task(folder: str) -> str:
    """Return what a command does, from the documentation of its module, which is not imported for that."""
    source = Path(__file__).with_name(folder).joinpath('command.py').read_text(encoding='utf-8')
    first = inspect.cleandoc(ast.get_docstring(ast.parse(source)) or '').partition('\n\n')[0]
    return ' '.join(first.partition(': ')[2].replace('`', '').split()).rstrip('.')


def _answer(word: str) -> str:
    """Return what an option prints; raise LookupError for another word."""
    if word in ('', '-h', '--help'):
        return _HELP.format(nodes='  '.join(NODES), commands='\n'.join(
            f'  {name:<12}{_task(folder)}' for name, folder in COMMANDS.items()))
    if word == '--version':
        return f'mrc {import_module("mobile_robot_control.version").__version__}\n'
    if word == '--completion':
        return _COMPLETION.format(names=' '.join([*COMMANDS, *NODES]))
    raise LookupError(word)


def main() -> int:
    """Run the command or the node that this executable, or its first word, has the name of; return its exit code."""
    called = Path(sys.argv[0]).name
    name, *arguments = [called, *sys.argv[1:]] if called in (*COMMANDS, *NODES) else sys.argv[1:] or ['']
    if name in NODES:
        return int(import_module('mobile_robot_control.ros.start.executables').run_nodes([name], arguments))
    if name in COMMANDS:
        try:
            command = import_module(f'mobile_robot_control.{COMMANDS[name]}.command')
        except ModuleNotFoundError as error:
            told = import_module('mobile_robot_control.system.texts').missing(error.name, name)
            sys.stderr.write(f'{name}: {told}\n')
            return 2
        return int(command.main(arguments))
    try:
        sys.stdout.write(_answer(name))
    except LookupError:
        near = import_module('mobile_robot_control.parameters.declaration').nearest(name, [*COMMANDS, *NODES])
        sys.stderr.write(f'mrc: there is no command {name!a}; {near}\n')
        return 2
    return 0


if __name__ == '__main__':
    sys.exit(main())
