"""Who may open the page; what libraries log is printed in printable lines, and a flood of requests reaches no node."""

import asyncio
import json
import logging
import types

import pytest

from mobile_robot_control.dashboard.actions import Answer
from mobile_robot_control.dashboard.link import RobotLink
from mobile_robot_control.dashboard.server import AccessGate, LogLines, PageServer, Served, _Session

HERE = '127.0.0.1:8080'


async def _application(_scope, _receive, send):
    await send({'type': 'http.response.start', 'status': 200, 'headers': []})


LOCAL = AccessGate(_application, frozenset({HERE}), '')
WITH_TOKEN = AccessGate(_application, frozenset(), 'secret')


def test_records_are_printable_lines_and_those_that_follow_soon_are_counted(capsys, monkeypatch):
    logger, now = logging.Logger('engineio.server'), [0.0]
    monkeypatch.setattr('time.monotonic', lambda: now[0])
    logger.addHandler(LogLines())
    logger.error('no page \x1b]0;X\x07\nTraceback')
    for now[0] in (1.0, 2.0, 3.0, 20.0):
        try:
            raise ValueError('\x1b[2J')
        except ValueError:
            logger.exception('a frame')
    assert capsys.readouterr().err.splitlines() == [
        'dashboard: engineio.server: no page \\x1b]0;X\\x07',
        'dashboard: engineio.server: a frame (ValueError: \\x1b[2J); 3 more before']


def test_a_page_has_one_request_of_a_kind_pending_and_further_ones_are_refused_in_words(tmp_path):
    fulfilled = []

    async def flood():
        answered = asyncio.Event()

        async def fulfil(request, _):
            fulfilled.append(request['number'])
            await answered.wait()
            return Answer(True, '')

        server = PageServer(Served(None, types.SimpleNamespace(fulfil=fulfil), dict, tmp_path), frozenset(), '')
        one, other = _Session(0), _Session(0)

        def ask(session, number, kind='set'):
            return asyncio.create_task(server._take(session, json.dumps({'do': kind, 'number': number})))

        asked = [*(ask(one, n) for n in range(200)), ask(one, 200, 'step'), ask(other, 201)]
        while len(fulfilled) < 3:
            await asyncio.sleep(0.0)
        answered.set()
        await asyncio.gather(*asked)
        await ask(one, 202)
        return [json.loads(one.waiting.get_nowait())[1] for _ in range(one.waiting.qsize())]

    answers = asyncio.run(flood())
    assert fulfilled == [0, 200, 201, 202]
    assert [number for number, good, _ in answers if good] == [0, 200, 202]
    refused = {text for _, good, text in answers if not good}
    assert refused == {"a request 'set' of this page has no answer yet; wait for it"}
    assert len(answers) == 202


def test_the_link_goes_on_after_the_jobs_that_wait_and_passes_over_those_of_a_page_that_has_gone():
    link, done = RobotLink('/'), []
    link.calls = link.disturbances = types.SimpleNamespace(look=lambda: done.append('looked'))

    def again():
        done.append('job')
        link.submit(again)

    link.submit(again)
    gone = link.submit(again)
    assert gone.cancel()
    answered = link.submit(lambda: 'answer')
    link._do_jobs()
    assert answered.result(0.0) == 'answer'
    assert done == ['job', 'looked', 'looked']


def _ask(gate, kind='http', path='/', query='', **headers):
    """Return status and headers of what an application behind the gate, or the gate itself, answers."""
    sent = []

    async def send(message):
        sent.append(message)

    scope = {'type': kind, 'path': path, 'query_string': query.encode(),
             'headers': [(name.encode(), value.encode()) for name, value in headers.items()]}
    asyncio.run(gate(scope, None, send))
    return sent[0].get('status', sent[0]['type']), dict(sent[0].get('headers', ()))


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
    assert _ask(LOCAL, **headers)[0] == status
    assert _ask(LOCAL, 'websocket', '/live', **headers)[0] == (200 if status == 200 else 'websocket.close')


@pytest.mark.parametrize(('site', 'mode', 'dest', 'status', 'prefetched'), [
    ('cross-site', 'no-cors', 'image', 403, 403), ('same-site', 'no-cors', 'empty', 403, 403),
    ('cross-site', 'navigate', 'iframe', 403, 403), ('cross-site', 'navigate', 'document', 200, 403),
    ('same-origin', 'cors', 'empty', 200, 200), ('none', 'navigate', 'document', 200, 200),
])
def test_another_page_may_lead_here_and_fetch_nothing(site, mode, dest, status, prefetched):
    told = {'host': HERE, 'sec-fetch-site': site, 'sec-fetch-mode': mode, 'sec-fetch-dest': dest}
    assert _ask(LOCAL, **told)[0] == status
    # a page that is only fetched before it is asked for
    assert _ask(LOCAL, **told, **{'sec-purpose': 'prefetch'})[0] == prefetched


def test_nothing_may_be_fetched_from_elsewhere_and_no_page_may_frame_this_one():
    policy = _ask(LOCAL, host=HERE)[1][b'content-security-policy']
    assert policy.startswith(b"default-src 'self'")
    assert b"frame-ancestors 'none'" in policy


def test_without_the_token_nothing_is_served():
    for cookie in ({}, {'cookie': 'mobile_robot_control_token=wrong'}, {'cookie': 'mobile_robot_control_token='},
                   {'cookie': '\xff;=;'}):
        for path, query in (('/', ''), ('/', 'token=wrong'), ('/', 'token='), ('/recordings/a', 'token=secret')):
            assert _ask(WITH_TOKEN, 'http', path, query, host='robot:80', **cookie)[0] == 403
        assert _ask(WITH_TOKEN, 'websocket', '/', 'token=secret', host='robot:80', **cookie)[0] == 'websocket.close'


def test_the_token_of_the_address_becomes_a_cookie_that_opens_everything():
    status, headers = _ask(WITH_TOKEN, query='token=secret', host='robot:80')
    assert (status, headers[b'location']) == (303, b'/')
    cookie, *attributes = headers[b'set-cookie'].decode().split('; ')
    assert {'HttpOnly', 'SameSite=Strict'} <= set(attributes)
    told = {'host': 'robot:80', 'cookie': cookie}
    assert [_ask(WITH_TOKEN, 'http', '/recordings/a', **told)[0], _ask(WITH_TOKEN, 'websocket', **told)[0]] == [200] * 2
    # and another origin still opens nothing
    assert _ask(WITH_TOKEN, **told, origin='http://evil.example')[0] == 403
