"""Access to the page: only for requests to this host, from its own pages, and with the token if there is one."""

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

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
        given = parse_qs(scope['query_string'].decode('latin-1')).get('token', [''])[0]
        return hmac.compare_digest(given.encode(), self._token.encode())


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
