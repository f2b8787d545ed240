"""
Runs cases, each in a process of its own that is forked from one in which everything is imported already.

A process itself: ``python -m hostile.arena``. It reads one JSON object a line (arguments of `run`) and writes one a
line (what `run` returns); where nothing can be read any more, it ends.
"""

import contextlib
import ctypes
import gc
import importlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
import traceback
import types
from pathlib import Path

from mobile_robot_control import __main__ as mrc

_SUBREAPER = 36
"""PR_SET_CHILD_SUBREAPER of Linux: what a case leaves behind becomes a child of this process."""
_GRACE = 20.0
"""[s] that an interrupted command has to end, and a helper process of one that has ended."""
COMMANDS = ('simulate', 'experiment', 'report', 'tune', 'study')


def _module(command):
    """Return the name of the module of a command."""
    return f'mobile_robot_control.{mrc.COMMANDS[command]}.command'


def main_of(command):
    """Return the entry point of a command, or a function that starts and ends a node."""
    if command in COMMANDS:
        return importlib.import_module(_module(command)).main
    from mobile_robot_control.ros.start.spin import spin
    from mobile_robot_control.system.process import prepare_streams

    def run_node():
        prepare_streams()
        # as the handler of a node does: it only asks for the end, which is asked for already
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        return spin([command], sys.argv[1:], types.SimpleNamespace(requested=True))

    return run_node


def _children():
    return [int(word) for word in Path(f'/proc/{os.getpid()}/task/{os.getpid()}/children').read_text().split()]


def _leftover():
    """Wait for what a case has left behind, and kill what does not end; returns the command lines of the latter."""
    deadline, left = time.monotonic() + _GRACE, []
    while _children():
        with contextlib.suppress(ChildProcessError):
            os.waitpid(-1, os.WNOHANG)
        if time.monotonic() > deadline:
            for pid in _children():
                with contextlib.suppress(OSError):
                    left.append(Path(f'/proc/{pid}/cmdline').read_text(errors='replace').replace('\0', ' '))
                    os.kill(pid, signal.SIGKILL)
        time.sleep(0.001)
    return left


def _computed(pid):
    """Return the CPU time of a process [s]."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def _wait(pid, seconds):
    """Wait for a process; interrupt it after so many seconds, and kill it where that is to no avail."""
    started, step, sent = time.monotonic(), 0.001, []
    limits = [(seconds, signal.SIGINT), (seconds + _GRACE, signal.SIGKILL)]

    def is_over(limit):
        # it ends between two steps; on a busy machine to compile one takes long, but does not hang
        passed = time.monotonic() - started
        return passed > limit and (not sent or passed > 10.0 * _GRACE or _computed(pid) > limit)

    while True:
        ended, status, usage = os.wait4(pid, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status), usage.ru_maxrss // 1024, [int(number) for number in sent]
        if limits and is_over(limits[0][0]):
            sent.append(limits.pop(0)[1])
            os.kill(pid, sent[-1])
        time.sleep(step)
        step = min(0.02, 1.2 * step)


def _start(case, streams):
    """Start a case; returns its process [pid]."""
    command, arguments = case['command'], case['arguments']
    if case['process']:
        words = [sys.executable, '-m', _module(command) if command in COMMANDS else
                 'mobile_robot_control.ros.start.executables', *([] if command in COMMANDS else [command]), *arguments]
        changed = {**os.environ, **case['environment']}
        environment = {name: value for name, value in changed.items() if value is not None}
        return subprocess.Popen(words, cwd=case['cwd'], env=environment, stdin=subprocess.DEVNULL, stdout=streams[0],
                                stderr=streams[1], start_new_session=True).pid
    pid = os.fork()
    if not pid:
        _perform(case, streams)
    return pid


def _perform(case, streams):
    """Run a case in this process, and end it."""
    command, arguments = case['command'], case['arguments']
    os.setsid()
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for number, stream in zip((1, 2), streams, strict=True):
        os.dup2(stream.fileno(), number)
    os.chdir(case['cwd'])
    if case['gone']:
        os.rmdir(case['cwd'])
    for name, value in case['environment'].items():
        os.environ.pop(name, None)
        os.environ.update({} if value is None else {name: value})
    sys.path[:0] = filter(None, [case['environment'].get('PYTHONPATH')])
    sys.argv = [command, *arguments]
    _end(main_of(command))


def _end(main):
    """Run a command and end, as Python does, but without the clearing up of all that was imported: it takes 0.1 s."""
    code = 1
    try:
        code = main()
    except SystemExit as error:
        code = error.code
    except BaseException:  # what Python prints, whatever it is
        traceback.print_exc()
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and not thread.daemon:
            thread.join()
    with contextlib.suppress(Exception):  # a case may have closed or replaced them
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(code if isinstance(code, int) else 1 if code else 0)


def run(case):
    """
    Run a case.

    Parameters
    ----------
    case : dict
        `command`, `arguments`, `cwd`, `environment`, `process`, `seconds`, `gone` (whether the folder is removed), and
        `printed`, the path of the files that take the standard streams, without their endings.

    Returns
    -------
    dict
        `code`, negative for a signal; `memory`, the largest [MB]; `sent`, the signals that it was sent; `left`, the
        command lines of processes left behind; `seconds`.

    """
    started = time.monotonic()
    with contextlib.ExitStack() as stack:
        streams = [stack.enter_context(open(f'{case["printed"]}.{end}', 'wb')) for end in ('stdout', 'stderr')]
        code, memory, sent = _wait(_start(case, streams), case['seconds'])
    return {'code': code, 'memory': memory, 'sent': sent, 'left': _leftover(), 'seconds': time.monotonic() - started}


def main():
    """Serve cases until the standard input ends."""
    ctypes.CDLL(None).prctl(_SUBREAPER, 1, 0, 0, 0)
    requests, answers = os.fdopen(os.dup(0), 'r'), os.fdopen(os.dup(1), 'w')
    os.dup2(2, 1)
    for command in COMMANDS:
        main_of(command)
    # imported once for all cases
    from mobile_robot_control.ros.start.loaded import LOADED, load
    from mobile_robot_control.settings.nodes import Configuration
    for module in ('experiment.runner', 'report.report_writing'):
        importlib.import_module(f'mobile_robot_control.{module}')
    for name in LOADED:
        load(name)
    if 'warm' in sys.argv:
        from mobile_robot_control.loop.batch import run_trials
        from mobile_robot_control.loop.trial import make_trial

        # compiled once for all cases: the forms of a search and of a study
        one = make_trial(Configuration(), 0.01)
        run_trials([one, one._replace(form=one.form._replace(indices=True))])
    # so that the collector leaves these pages to be shared by all cases
    gc.freeze()
    for line in requests:
        print(json.dumps(run(json.loads(line))), file=answers, flush=True)


if __name__ == '__main__':
    main()
