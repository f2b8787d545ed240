"""A process that plans paths for a node on the wall clock, which continues its steps meanwhile."""

import pickle
import subprocess
import sys
import time
from concurrent.futures import Future, ThreadPoolExecutor

from mobile_robot_control.ros.path_planning import PathAnswer, PathQuestion, answer
from mobile_robot_control.system.supervisor import is_suspended

_PATIENCE = 3.0
"""[s] for which a suspended process may keep a question."""


class PlanningProcess:
    """Answers questions, one after the other; it ends with its parent process."""

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1)
        self._closed = False
        self._ran = time.monotonic()
        self._start()

    def _start(self) -> None:
        # its own session: Ctrl-C is for the node
        self._process = subprocess.Popen([sys.executable, '-m', __name__], stdin=subprocess.PIPE,  # noqa: S603 (ours)
                                         stdout=subprocess.PIPE, start_new_session=True)

    def ask(self, question: PathQuestion) -> 'Future[PathAnswer]':
        """Begin to plan."""
        self._ran = time.monotonic()
        return self._thread.submit(self._exchange, question)

    def _exchange(self, question: PathQuestion) -> PathAnswer:
        """Return the answer of the process; restart a killed process once."""
        for again in (False, True):
            if self._closed:
                break
            if again:
                self._process.wait()
                self._start()
            assert self._process.stdin is not None  # noqa: S101 (for mypy: pipes)
            assert self._process.stdout is not None  # noqa: S101
            try:
                pickle.dump(question, self._process.stdin)
                self._process.stdin.flush()
                found: PathAnswer = pickle.load(self._process.stdout)  # noqa: S301 (our own process)
                return found
            except (OSError, EOFError, pickle.UnpicklingError):
                continue
        return PathAnswer(None, [], ('not planned', 'the process that plans has ended twice; is there enough memory?'))

    def kill_suspended(self) -> bool:
        """Kill a process that has been suspended for some seconds: another one answers its question; return whether."""
        now = time.monotonic()
        if not is_suspended(self._process.pid):
            self._ran = now
        if now - self._ran < _PATIENCE:
            return False
        self._ran = now
        self._process.kill()
        return True

    def close(self) -> None:
        """End the process."""
        self._closed = True
        self._process.kill()
        self._process.wait()
        self._thread.shutdown()


def _serve() -> None:
    """Answer questions on the standard input until it closes."""
    while True:
        try:
            question = pickle.load(sys.stdin.buffer)  # noqa: S301 (of the node that has started this process)
        except EOFError:
            return
        pickle.dump(answer(question), sys.stdout.buffer)
        sys.stdout.buffer.flush()


if __name__ == '__main__':
    _serve()
