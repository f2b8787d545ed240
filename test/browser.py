"""A headless Chromium, driven over the pipe of its DevTools protocol."""

import itertools
import json
import os
import select
import shutil
import subprocess
import time

from processes import wait_until

CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')


class Browser:
    """One page; a context manager."""

    def __init__(self, profile):
        to_browser, self._out = os.pipe()
        self._in, from_browser = os.pipe()

        def plug():
            # Chromium reads commands from descriptor 3 and answers on 4; away from there first
            read, write = os.dup2(to_browser, 30), os.dup2(from_browser, 31)
            os.dup2(read, 3)
            os.dup2(write, 4)

        self._process = subprocess.Popen(
            [CHROMIUM, '--headless', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage', '--no-first-run',
             '--disable-background-networking', f'--user-data-dir={profile}', '--remote-debugging-pipe'],
            preexec_fn=plug, close_fds=False,  # noqa: PLW1509 (no threads here)
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        os.close(to_browser)
        os.close(from_browser)
        self._buffer, self._numbers, self._session = b'', itertools.count(1), None
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        self._session = self.call('Target.attachToTarget', targetId=target, flatten=True)['sessionId']

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.terminate()
        self._process.wait(timeout=20)
        os.close(self._out)
        os.close(self._in)

    def _receive(self, deadline):
        while b'\0' not in self._buffer:
            assert select.select([self._in], [], [], max(0.0, deadline - time.monotonic()))[0], 'Chromium timed out'
            piece = os.read(self._in, 1 << 16)
            assert piece, 'Chromium has ended'
            self._buffer += piece
        message, _, self._buffer = self._buffer.partition(b'\0')
        return json.loads(message)

    def call(self, method, **parameters):
        """Send a command and return its result."""
        number, deadline = next(self._numbers), time.monotonic() + 40.0
        session = {'sessionId': self._session} if self._session else {}
        command = {'id': number, 'method': method, 'params': parameters, **session}
        os.write(self._out, json.dumps(command).encode() + b'\0')
        while True:
            answer = self._receive(deadline)
            if answer.get('id') == number:
                assert 'error' not in answer, answer
                return answer['result']

    def evaluate(self, expression):
        """Return the value of a JavaScript expression in the page; a promise is awaited."""
        answer = self.call('Runtime.evaluate', expression=expression, awaitPromise=True, returnByValue=True)
        assert 'exceptionDetails' not in answer, answer
        return answer['result'].get('value')

    def show(self, path, width, scheme='light'):
        """Open a file at a width of the window, on light or dark ground, and wait until it is drawn."""
        self.call('Emulation.setDeviceMetricsOverride', width=width, height=900, deviceScaleFactor=1,
                  mobile=width < 600)
        self.call('Emulation.setEmulatedMedia', features=[{'name': 'prefers-color-scheme', 'value': scheme}])
        self.call('Page.navigate', url=path.as_uri())
        wait_until(
            lambda: self.evaluate('[location.href, document.readyState]') == [path.as_uri(), 'complete'], 40.0, 0.02)
        self.evaluate('Promise.all([...document.images].map(image => image.decode().catch(() => 0)))')
