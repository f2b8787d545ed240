"""What libraries log is printed in printable lines, and a flood of requests reaches neither nodes nor sampling."""

import asyncio
import json
import logging
import types

from mobile_robot_control.dashboard.actions import Answer
from mobile_robot_control.dashboard.link import RobotLink
from mobile_robot_control.dashboard.server import LogLines, PageServer, Served, _Session


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
