"""A process that plans paths for a node on the wall clock, which continues its steps meanwhile."""

import os
import pickle
import resource
import subprocess
import sys
import time
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Event

from mobile_robot_control.ros.cart.path_planning import PathAnswer, PathQuestion, planned
from mobile_robot_control.system.supervisor import is_suspended

_PATIENCE = 3.0
"""[s] for which a suspended process may keep a question."""
_MEMORY = 1 << 30
"""[bytes] of the process."""


def not_planned(topic: str, why: str) -> PathAnswer:
    """Return the answer to a message of a topic that has no plan: the cart stops."""
    return PathAnswer(None, [], ('not planned', why), stops=True, topic=topic)


class PlanningProcess:
    """Answers questions, one after the other; it ends with its parent process."""

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1)
        self._closed = False
        self._dropped = Event()
        self._ran = time.monotonic()
        self._start()

    def _start(self) -> None:
        # its own session: Ctrl-C is for the node; one thread: each would take its share of the memory
        self._process = subprocess.Popen(  # noqa: S603 (ours)
            [sys.executable, '-m', __name__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True,
            env={**os.environ, 'OPENBLAS_NUM_THREADS': '1'})

    def ask(self, question: PathQuestion) -> 'Future[PathAnswer]':
        """Begin to plan."""
        self._ran = time.monotonic()
        self._dropped = Event()
        return self._thread.submit(self._exchange, question, self._dropped)

    def drop(self) -> None:
        """Drop the question: its process is killed, and another one answers the next question."""
        self._dropped.set()
        self._process.kill()

    def _exchange(self, question: PathQuestion, dropped: Event) -> PathAnswer:
        """Return the answer of the process; restart a killed process, and ask it once more."""
        for again in (False, True):
            if self._closed:
                break
            if again:
                self._process.wait()
                self._start()
                if dropped.is_set():
                    return not_planned(question.topic, 'the question was dropped')
            assert self._process.stdin is not None  # noqa: S101 (for mypy: pipes)
            assert self._process.stdout is not None  # noqa: S101
            try:
                pickle.dump(question, self._process.stdin)
                self._process.stdin.flush()
                answer: PathAnswer = pickle.load(self._process.stdout)  # noqa: S301 (our own process)
                return answer
            except (OSError, EOFError, pickle.UnpicklingError):
                continue
        return not_planned(question.topic, 'the process that plans has ended twice; is there enough memory?')

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
    resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, _MEMORY))
    while True:
        try:
            question = pickle.load(sys.stdin.buffer)  # noqa: S301 (of the node that has started this process)
        except EOFError:
            return
        try:
            answer = planned(question)
        except MemoryError:
            answer = not_planned(
                question.topic, f'its plan needs more than {_MEMORY >> 30} GB; publish fewer or nearer poses')
        pickle.dump(answer, sys.stdout.buffer)
        sys.stdout.buffer.flush()


if __name__ == '__main__':
    _serve()
