"""The page server: one page, its socket, 20 packed rows a second, and access for requests to this host alone."""

import asyncio
import contextlib
import hmac
import json
import logging
import math
import socket
import sys
import time
from collections.abc import Awaitable, Callable, Iterator, MutableMapping
from functools import partial
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import parse_qs

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from mobile_robot_control.dashboard.actions import Actions
from mobile_robot_control.dashboard.link import PERIOD, RobotLink
from mobile_robot_control.dashboard.markup import PAGE
from mobile_robot_control.dashboard.service_calls import Answer
from mobile_robot_control.dashboard.snapshot import shown_parameters
from mobile_robot_control.pages.page import pack
from mobile_robot_control.system.texts import describe_error, shortened

_COOKIE = 'mobile_robot_control_token'
_HEADERS = [
    # everything comes from here, and no other page may show this one
    (b'content-security-policy', b"default-src 'self' 'unsafe-inline' data: blob:; "
     b"frame-ancestors 'none'; base-uri 'none'; form-action 'none'"),
    (b'x-content-type-options', b'nosniff'), (b'referrer-policy', b'no-referrer'),
    (b'cache-control', b'no-cache'),
]
Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Any]]
Send = Callable[[Any], Awaitable[None]]


class AccessGate:
    """
    An ASGI middleware that refuses all other requests, to pages and sockets alike.

    Parameters
    ----------
    app : callable
        The application behind the gate.
    hosts : frozenset of str
        Values of the header Host that name this server; empty allows any, if a token is required. A page with a name
        that is resolved to this machine (DNS rebinding) has another one.
    token : str
        Required once in the address; '' for none.

    """

    def __init__(
        self, app: Callable[[Scope, Receive, Send], Awaitable[None]], hosts: frozenset[str], token: str
    ) -> None:
        self._app, self._hosts, self._token = app, hosts, token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request through, or refuse it."""
        if scope['type'] not in ('http', 'websocket'):
            await self._app(scope, receive, send)
            return
        headers = {name.decode('latin-1').lower(): value.decode('latin-1') for name, value in scope['headers']}
        refused = self._refusal(headers, scope)
        if refused:
            await _refuse(scope, send, refused)
        elif self._asks_for_cookie(scope):
            await _redirect(send, self._token)
        else:
            await self._app(scope, receive, _with_headers(send))

    def _refusal(self, headers: dict[str, str], scope: Scope) -> str:
        """Return the reason to refuse a request; '' if there is none."""
        host = headers.get('host', '')
        if self._hosts and host not in self._hosts:
            return 'this page is served under another name'
        if _is_of_another_page(headers, host):
            return 'another page may not open this one'
        if self._token and not (self._has_cookie(headers) or self._asks_for_cookie(scope)):
            return 'open the address with the token that the command has printed'
        return ''

    def _has_cookie(self, headers: dict[str, str]) -> bool:
        try:
            cookie = SimpleCookie(headers.get('cookie', '')).get(_COOKIE)
        except CookieError:
            return False
        return cookie is not None and hmac.compare_digest(cookie.value.encode(), self._token.encode())

    def _asks_for_cookie(self, scope: Scope) -> bool:
        if not self._token or scope['type'] != 'http' or scope['path'] != '/':
            return False
        token = parse_qs(scope['query_string'].decode('latin-1')).get('token', [''])[0]
        return hmac.compare_digest(token.encode(), self._token.encode())


def _is_of_another_page(headers: dict[str, str], host: str) -> bool:
    """Return whether another page has made a request, by the headers of browsers; its links may lead here."""
    if 'origin' in headers and headers['origin'] != f'http://{host}':
        return True
    follows_link = (headers.get('sec-fetch-mode') == 'navigate' and headers.get('sec-fetch-dest') == 'document'
                    and 'sec-purpose' not in headers)
    return headers.get('sec-fetch-site', 'none') not in ('none', 'same-origin') and not follows_link


def _with_headers(send: Send) -> Send:
    """Add the headers of the gate to an answer."""
    async def sending(message: Any) -> None:
        if message['type'] == 'http.response.start':
            message = {**message, 'headers': [*message.get('headers', []), *_HEADERS]}
        await send(message)

    return sending


async def _refuse(scope: Scope, send: Send, reason: str) -> None:
    if scope['type'] == 'websocket':
        # before it is accepted, this is an answer 403
        await send({'type': 'websocket.close', 'code': 1008, 'reason': reason})
        return
    await send({'type': 'http.response.start', 'status': 403,
                'headers': [(b'content-type', b'text/plain; charset=utf-8'), *_HEADERS]})
    await send({'type': 'http.response.body', 'body': f'refused: {reason}\n'.encode()})


async def _redirect(send: Send, token: str) -> None:
    """Move the token from the address to a cookie."""
    cookie = f'{_COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/'
    await send({'type': 'http.response.start', 'status': 303,
                'headers': [(b'location', b'/'), (b'set-cookie', cookie.encode()), *_HEADERS]})
    await send({'type': 'http.response.body', 'body': b''})


_QUIET = 10.0
"""[s] after a line in which further ones are only counted."""


class LogLines(logging.Handler):
    """Prints records as one printable line each, without tracebacks, and counts those that come too fast."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._printed_at, self._left_out = -math.inf, 0

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record, or count it."""
        now = time.monotonic()
        if now - self._printed_at < _QUIET:
            self._left_out += 1
            return
        line = shortened(record.getMessage().strip().partition('\n')[0])
        if record.exc_info and record.exc_info[1]:
            line += f' ({describe_error(record.exc_info[1])})'
        more = f'; {self._left_out} more before' if self._left_out else ''
        self._printed_at, self._left_out = now, 0
        print(f'dashboard: {record.name}: {line}{more}', file=sys.stderr, flush=True)


def log_in_lines() -> None:
    """Print everything that is logged in this process in this form."""
    logging.basicConfig(handlers=[LogLines()], force=True)


_UNANSWERED = 40
"""Most messages in transit to a browser; a slower browser misses rows."""
_STATE = 0.5
"""[s] of wall time between two reads of the state."""
_REMEMBERED = 60.0
"""[s] of wall time for which topics are sampled after the last page is closed."""
_GRACE = 5.0
"""[s] of wall time until the lesson of a closed page ends."""
_LARGEST = 1 << 20
"""Largest request in bytes."""


class _Session:
    """A browser with the page open: the data sent to it, and the data that wait."""

    def __init__(self, next_row: int) -> None:
        self.next_row = next_row
        self.sent = self.received = 0
        self.told: dict[str, str] = {}
        self.topics = False
        self.asked: set[str] = set()
        self.waiting: asyncio.Queue[str] = asyncio.Queue()

    def send(self, kind: str, value: str) -> None:
        """Send a value, as JSON, to the function of the page's script for its kind."""
        self.waiting.put_nowait(f'["{kind}",{value}]')


class Served(NamedTuple):
    """
    The sources of the page.

    Attributes
    ----------
    link : RobotLink
        To the robot.
    actions : Actions
        Fulfils requests.
    state : callable
        Returns the state ready for JSON; called in the link's thread.
    folder : Path
        For recordings and saved parameters.

    """

    link: RobotLink
    actions: Actions
    state: Callable[[], dict[str, Any]]
    folder: Path


class PageServer:
    """
    Serves the page until it is stopped.

    Parameters
    ----------
    served : Served
        The sources of the page.
    hosts : frozenset of str
        See `AccessGate`.
    token : str
        See `AccessGate`.

    """

    def __init__(self, served: Served, hosts: frozenset[str], token: str) -> None:
        self._served = served
        self._sessions: set[_Session] = set()
        self._parameters = (-1, '')
        self._left = -math.inf
        self._leaving: set[asyncio.Task[None]] = set()
        log_in_lines()
        folders = []
        for name in ('recordings', 'saved'):
            folder = served.folder / name
            folder.mkdir(parents=True, exist_ok=True)
            folders.append(Mount(f'/{name}', StaticFiles(directory=folder)))
        app = Starlette(routes=[Route('/', _page), WebSocketRoute('/live', self._open), *folders],
                        exception_handlers={404: _not_found})
        self._gate = AccessGate(app, hosts, token)

    async def _open(self, browser: WebSocket) -> None:
        """Serve a browser until it is gone."""
        sequence = browser.query_params.get('from', '')
        session = _Session(int(sequence) if sequence.isascii() and sequence.isdecimal() and len(sequence) < 16 else 0)
        await browser.accept()
        self._sessions.add(session)
        session.send('lessons', json.dumps(self._served.actions.teaching.shown()))
        tasks = {asyncio.create_task(_send(browser, session))}
        try:
            while True:
                answering = asyncio.create_task(self._take(session, await browser.receive_text()))
                tasks.add(answering)
                answering.add_done_callback(tasks.discard)
        except (WebSocketDisconnect, KeyError):  # it is gone, or sends bytes
            pass
        finally:
            self._sessions.discard(session)
            self._leaving.add(leaving := asyncio.create_task(self._leave(session)))
            leaving.add_done_callback(self._leaving.discard)
            for task in list(tasks):
                task.cancel()

    async def _leave(self, session: _Session) -> None:
        """End the lesson of a closed page, unless another page has restarted it."""
        await asyncio.sleep(_GRACE)
        with contextlib.suppress(Exception):  # its nodes may be gone, too
            await self._served.actions.teaching.end(session)

    async def _take(self, session: _Session, message: str) -> None:
        """Handle any message of a page."""
        try:
            request = json.loads(message)
        except (ValueError, RecursionError):
            request = None
        request = request if isinstance(request, dict) else {}
        if request.get('do') == 'received':
            session.received = session.sent
        elif request.get('do') == 'topics':
            session.topics = request.get('shown') is True
        else:
            answer, number = await self._answer(request, session), request.get('number')
            session.send('answer', json.dumps([number if isinstance(number, int) else 0, answer.good, answer.text]))

    async def _answer(self, request: dict[str, Any], session: _Session) -> Answer:
        """Fulfil a request, unless the same page waits for another one of its kind: a flood of them stalls the loop."""
        kind = str(request.get('do'))
        if kind in session.asked:
            return Answer(False, f"a request '{shortened(kind, 20)}' of this page has no answer yet; wait for it")
        session.asked.add(kind)
        try:
            return await self._served.actions.fulfil(request, session)
        finally:
            session.asked.remove(kind)

    def run(self, listening: socket.socket, stopped: Callable[[], bool]) -> None:
        """Serve on a socket until `stopped` returns True."""
        asyncio.run(self._run(listening, stopped))

    async def _run(self, listening: socket.socket, stopped: Callable[[], bool]) -> None:
        server = _Server(uvicorn.Config(
            self._gate, log_config=None, log_level='error', access_log=False, ws_per_message_deflate=False,
            ws_max_size=_LARGEST, timeout_graceful_shutdown=1, server_header=False, lifespan='off'))
        serving = asyncio.create_task(server.serve(sockets=[listening]))
        look = 0.0
        while not stopped() and not serving.done():
            now = asyncio.get_running_loop().time()
            if self._sessions:
                self._left = now
            # a reloaded page begins with the last minute
            self._served.link.wanted = now - self._left < _REMEMBERED
            try:
                self._send_rows()
                if now >= look:
                    look = now + _STATE
                    await self._send_state()
            except Exception as error:  # one bad message must not end the page
                print(f'dashboard: {describe_error(error)}')
            await asyncio.sleep(max(0.0, now + PERIOD - asyncio.get_running_loop().time()))
        server.should_exit = True
        await serving

    def _present(self) -> Iterator[_Session]:
        """Yield the browsers that keep up."""
        return (session for session in list(self._sessions) if session.sent - session.received < _UNANSWERED)

    def _send_rows(self) -> None:
        frames = list(self._served.link.frames)
        for session in self._present():
            rows = [frame.row for frame in frames if frame.number >= session.next_row]
            # the state first: it names the columns
            if rows and session.told:
                session.next_row = frames[-1].number + 1
                session.sent += 1
                session.send('rows', json.dumps([pack(rows), session.next_row]))

    async def _send_state(self) -> None:
        """Send each browser the changes of the state."""
        link, sessions = self._served.link, list(self._present())
        if not sessions:
            return
        texts = {'state': await self._text(self._served.state), 'parameters': await self._parameters_text()}
        if any(session.topics for session in sessions):
            texts['topics'] = await self._text(link.topic_table)
        for session in sessions:
            for name, content in texts.items():
                if session.told.get(name) != content and (name != 'topics' or session.topics):
                    session.told[name] = content
                    session.send(name, content)

    async def _text(self, look: Callable[[], Any]) -> str:
        """Return the result of a function in the link's thread as JSON."""
        return json.dumps(await asyncio.wrap_future(self._served.link.submit(look)))

    async def _parameters_text(self) -> str:
        """Return the parameters as JSON, made once for each version of them."""
        version = self._served.link.book.version
        if self._parameters[0] != version:
            self._parameters = (version, await self._text(partial(shown_parameters, self._served.link)))
        return self._parameters[1]


async def _send(browser: WebSocket, session: _Session) -> None:
    """Send the waiting data of a browser, one after the other: a slow browser delays no other."""
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # it is gone
        while True:
            await browser.send_text(await session.waiting.get())


async def _page(_request: Request) -> HTMLResponse:
    return HTMLResponse(PAGE)


async def _not_found(_request: Request, _error: Exception) -> PlainTextResponse:
    return PlainTextResponse('there is nothing here\n', 404)


class _Server(uvicorn.Server):
    """A server that leaves signals to the command."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Do nothing: the command has its own handlers."""
        yield
