"""The page server: one page, its socket, and 20 packed rows a second to every browser that has it open."""

import asyncio
import contextlib
import json
import socket
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import uvicorn
from fastapi import FastAPI, Request
from fastapi.responses import PlainTextResponse
from nicegui import Client, app, ui

from mobile_robot_control.dashboard.access import AccessGate
from mobile_robot_control.dashboard.actions import Actions
from mobile_robot_control.dashboard.link import PERIOD, RobotLink
from mobile_robot_control.dashboard.log_lines import log_in_lines
from mobile_robot_control.dashboard.markup import HEAD, SKELETON
from mobile_robot_control.dashboard.snapshot import shown_parameters
from mobile_robot_control.system.texts import describe_error
from mobile_robot_control.web.packing import pack

_UNANSWERED = 40
"""Messages under way to a browser at most; one that is slower leaves out rows."""
_STATE = 0.5
"""[s] of wall time between two looks at the state."""
_RECONNECT = 20.0
"""[s] after which a browser that does not answer counts as gone; a busy machine answers late."""
_RESENT = 100
"""Messages that are sent again after a moment without a connection; without them nicegui loads the page again."""
_UNOPENED = 16
"""Pages that were fetched and have not opened their socket yet; older ones are forgotten."""
_TITLE = 'mobile_robot_control'


class _Session:
    """A browser that has the page open."""

    def __init__(self, client: Client) -> None:
        self.client = client
        self.sent = self.received = 0
        self.next_row = 0
        self.told: dict[str, str] = {}
        self.topics = False

    def send(self, function: str, value: Any) -> None:
        """Call a function of the page's script with a value as JSON."""
        # ASCII alone: no text can end the script that it stands in
        self.client.run_javascript(f'mrc.live.{function}({json.dumps(value)})')


class Served(NamedTuple):
    """
    What the page is served from.

    Attributes
    ----------
    link : RobotLink
        To the robot.
    actions : Actions
        Fulfils requests.
    state : callable
        Returns the state as JSON has it; called in the link's thread.
    folder : Path
        Of what is written: recordings and saved parameters.

    """

    link: RobotLink
    actions: Actions
    state: Callable[[], dict[str, Any]]
    folder: Path


class PageServer:
    """
    Serves the page until told to stop.

    Parameters
    ----------
    served : Served
        What it shows and does.
    hosts : frozenset of str
        See `AccessGate`.
    token : str
        See `AccessGate`.

    """

    def __init__(self, served: Served, hosts: frozenset[str], token: str) -> None:
        self._served = served
        self._sessions: dict[str, _Session] = {}
        self._parameters = (-1, '')
        log_in_lines()
        # shared: each page would keep a copy
        ui.add_head_html(HEAD, shared=True)
        ui.page('/', title=_TITLE)(self._page)
        # nicegui's own makes a page for each address, and logs it
        app.add_exception_handler(404, _not_found)
        for name in ('recordings', 'saved'):
            folder = served.folder / name
            folder.mkdir(parents=True, exist_ok=True)
            app.add_static_files(f'/{name}', folder, max_cache_age=0)
        outer = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        ui.run_with(outer, title=_TITLE, show_welcome_message=False, tailwind=False, dark=None,
                    message_history_length=_RESENT, binding_refresh_interval=None, reconnect_timeout=_RECONNECT)
        self._gate = AccessGate(outer, hosts, token)

    def _page(self, client: Client) -> None:
        """Make the page for a browser."""
        _forget_unopened()
        ui.html(SKELETON, sanitize=False)
        session = _Session(client)
        ui.on('mrc', partial(self._on_wish, session))
        client.on_connect(lambda: self._sessions.setdefault(client.id, session))
        client.on_delete(lambda: self._sessions.pop(client.id, None))

    async def _on_wish(self, session: _Session, event: Any) -> None:
        """Take what a page has sent, whatever it is."""
        request = event.args if isinstance(event.args, dict) else {}
        if request.get('do') == 'received':
            session.received = session.sent
        elif request.get('do') == 'topics':
            session.topics = request.get('shown') is True
        else:
            answer = await self._served.actions.fulfil(request)
            number = request.get('number')
            session.send('answer', [number if isinstance(number, int) else 0, answer.good, answer.text])

    def run(self, listening: socket.socket, stopped: Callable[[], bool]) -> None:
        """Serve on a socket until `stopped` returns True."""
        asyncio.run(self._run(listening, stopped))

    async def _run(self, listening: socket.socket, stopped: Callable[[], bool]) -> None:
        server = _Server(uvicorn.Config(
            self._gate, log_config=None, log_level='error', access_log=False, ws_per_message_deflate=False,
            ws_max_size=1 << 20, timeout_graceful_shutdown=1, server_header=False))
        serving = asyncio.create_task(server.serve(sockets=[listening]))
        look = 0.0
        while not stopped() and not serving.done():
            now = asyncio.get_running_loop().time()
            self._served.link.wanted = bool(self._sessions)
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
        """Yield the browsers that are connected and keep up."""
        for session in list(self._sessions.values()):
            if session.client.has_socket_connection and session.sent - session.received < _UNANSWERED:
                yield session

    def _send_rows(self) -> None:
        frames = list(self._served.link.frames)
        for session in self._present():
            rows = [frame.row for frame in frames if frame.number >= session.next_row]
            if rows:
                session.next_row = frames[-1].number + 1
                session.sent += 1
                session.client.run_javascript(f"mrc.live.rows('{pack(rows)}')")

    async def _send_state(self) -> None:
        """Tell each browser what has changed of the state."""
        link, sessions = self._served.link, list(self._present())
        if not sessions:
            return
        texts = {'state': await self._text(self._served.state), 'parameters': await self._parameters_text()}
        if any(session.topics for session in sessions):
            texts['topics'] = await self._text(link.topic_table)
        for session in sessions:
            for name, text in texts.items():
                if session.told.get(name) != text and (name != 'topics' or session.topics):
                    session.told[name] = text
                    session.client.run_javascript(f'mrc.live.{name}({text})')


    async def _text(self, look: Callable[[], Any]) -> str:
        """Return as JSON what a function finds in the link's thread."""
        return json.dumps(await asyncio.wrap_future(self._served.link.submit(look)))

    async def _parameters_text(self) -> str:
        """Return the parameters as JSON, made once for each version of them."""
        version = self._served.link.book.version
        if self._parameters[0] != version:
            self._parameters = (version, await self._text(partial(shown_parameters, self._served.link)))
        return self._parameters[1]


def _forget_unopened() -> None:
    """Forget the oldest pages that were fetched and not opened: any page on the web can have them fetched."""
    unopened = [client for client in Client.instances.values() if client.environ is None]
    for client in unopened[:-_UNOPENED]:
        client.delete()


async def _not_found(_request: Request, _error: Exception) -> PlainTextResponse:
    return PlainTextResponse('there is nothing here\n', 404)


class _Server(uvicorn.Server):
    """A server that leaves signals to the command."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Do nothing: the command has handlers of its own."""
        yield
