"""Who may open the page."""

import asyncio

import pytest

from mobile_robot_control.dashboard.access import AccessGate

HERE = '127.0.0.1:8080'


def _ask(gate, kind='http', path='/', query='', **headers):
    """Return what an application behind the gate, or the gate itself, answers."""
    sent = []

    async def send(message):
        sent.append(message)

    scope = {'type': kind, 'path': path, 'query_string': query.encode(),
             'headers': [(name.encode(), value.encode()) for name, value in headers.items()]}
    asyncio.run(gate(scope, None, send))
    return sent


async def _application(_scope, _receive, send):
    await send({'type': 'http.response.start', 'status': 200, 'headers': []})


def _status(answer):
    return answer[0].get('status', answer[0]['type'])


LOCAL = AccessGate(_application, frozenset({HERE}), '')
WITH_TOKEN = AccessGate(_application, frozenset(), 'secret')


@pytest.mark.parametrize(('headers', 'status'), [
    ({'host': HERE}, 200),
    ({'host': HERE, 'origin': f'http://{HERE}'}, 200),
    ({'host': HERE, 'origin': 'http://evil.example'}, 403),
    ({'host': HERE, 'origin': 'null'}, 403),
    ({'host': HERE, 'origin': f'https://{HERE}'}, 403),
    # a name that was made to resolve to this machine
    ({'host': 'evil.example:8080', 'origin': 'http://evil.example:8080'}, 403),
    ({'host': '127.0.0.1:8081'}, 403),
    ({}, 403),
])
def test_only_requests_to_this_host_from_its_own_pages_pass(headers, status):
    assert _status(_ask(LOCAL, **headers)) == status
    socket = _ask(LOCAL, 'websocket', '/live', **headers)
    assert _status(socket) == (200 if status == 200 else 'websocket.close')


@pytest.mark.parametrize(('site', 'mode', 'dest', 'status'), [
    ('cross-site', 'no-cors', 'image', 403), ('same-site', 'no-cors', 'empty', 403),
    ('cross-site', 'navigate', 'iframe', 403), ('cross-site', 'navigate', 'document', 200),
    ('same-origin', 'cors', 'empty', 200), ('none', 'navigate', 'document', 200),
])
def test_another_page_may_lead_here_and_fetch_nothing(site, mode, dest, status):
    told = {'sec-fetch-site': site, 'sec-fetch-mode': mode, 'sec-fetch-dest': dest}
    assert _status(_ask(LOCAL, host=HERE, **told)) == status
    # a page that is only fetched before it is asked for
    assert _status(_ask(LOCAL, host=HERE, **told, **{'sec-purpose': 'prefetch'})) == (
        status if site in ('same-origin', 'none') else 403)


def test_nothing_may_be_fetched_from_elsewhere_and_no_page_may_frame_this_one():
    headers = dict(_ask(LOCAL, host=HERE)[0]['headers'])
    assert headers[b'content-security-policy'].startswith(b"default-src 'self'")
    assert b"frame-ancestors 'none'" in headers[b'content-security-policy']


@pytest.mark.parametrize('headers', [
    {}, {'cookie': 'mobile_robot_control_token=wrong'}, {'cookie': 'mobile_robot_control_token='},
    {'cookie': '\xff;=;'},
])
def test_without_the_token_nothing_is_served(headers):
    for path, query in (('/', ''), ('/', 'token=wrong'), ('/', 'token='), ('/recordings/a', 'token=secret')):
        assert _status(_ask(WITH_TOKEN, path=path, query=query, host='robot:80', **headers)) == 403
    assert _status(_ask(WITH_TOKEN, 'websocket', '/', 'token=secret', host='robot:80', **headers)) == 'websocket.close'


def test_the_token_of_the_address_becomes_a_cookie_that_opens_everything():
    moved = _ask(WITH_TOKEN, query='token=secret', host='robot:80')
    assert moved[0]['status'] == 303
    headers = dict(moved[0]['headers'])
    assert headers[b'location'] == b'/'
    assert b'HttpOnly' in headers[b'set-cookie']
    assert b'SameSite=Strict' in headers[b'set-cookie']
    cookie = headers[b'set-cookie'].decode().partition(';')[0]
    assert _status(_ask(WITH_TOKEN, path='/recordings/a', host='robot:80', cookie=cookie)) == 200
    assert _status(_ask(WITH_TOKEN, 'websocket', host='robot:80', cookie=cookie)) == 200
    # and another origin still opens nothing
    assert _status(_ask(WITH_TOKEN, host='robot:80', cookie=cookie, origin='http://evil.example')) == 403
