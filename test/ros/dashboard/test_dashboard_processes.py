"""How the command `dashboard` begins and ends: ports, tokens, strangers, and `kill -9`."""

import asyncio
import http.client
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import rclpy
import websockets
from helpers.live_page import LivePage, megabytes
from helpers.processes import wait_until

from mobile_robot_control.experiment.node_processes import NodeProcess, stop_processes
from mobile_robot_control.topics import LOOPS

SOCKET = '/live?from='


def _status(address, path='/', **headers):
    """Return the status of an answer."""
    host = address.split('/')[2]
    connection = http.client.HTTPConnection(host, timeout=20)
    try:
        connection.request('GET', path, headers={name.replace('_', '-'): value for name, value in headers.items()})
        return connection.getresponse().status
    finally:
        connection.close()


def _upgrade(address, origin):
    """Return the status of the answer to a request for a websocket."""
    return _status(address, f'{SOCKET}0', Connection='Upgrade', Upgrade='websocket', Origin=origin,
                   Sec_WebSocket_Version='13', Sec_WebSocket_Key='dGhlIHNhbXBsZSBub25jZQ==')


def _run(tmp_path, *arguments, **variables):
    return subprocess.run([sys.executable, '-m', 'mobile_robot_control.dashboard.command', '--output', tmp_path,
                           *arguments],
                          capture_output=True, text=True, timeout=120, env=os.environ | variables, check=False)


def _is_running(pid):
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except OSError:
        return False


def _refusal(tmp_path, *arguments, **variables):
    """Return the one line with which the command refuses to start."""
    done = _run(tmp_path, *arguments, **variables)
    assert done.returncode == 2
    line, = done.stderr.splitlines()
    return line


def test_a_port_that_is_taken_and_a_missing_extra_are_one_line_with_the_remedy(domain, tmp_path):
    with socket.create_server(('127.0.0.1', 0)) as taken:
        line = _refusal(tmp_path, '--port', str(taken.getsockname()[1]))
    assert 'Address already in use' in line
    assert '--port' in line
    (tmp_path / 'starlette.py').write_text("raise ModuleNotFoundError('no', name='starlette')\n")
    line = _refusal(tmp_path, PYTHONPATH=f'{tmp_path}{os.pathsep}{os.environ.get("PYTHONPATH", "")}')
    assert 'starlette' in line
    assert 'pip install starlette' in line


def test_a_signal_ends_the_page_and_its_nodes(domain, tmp_path):
    page = LivePage(tmp_path)
    wait_until(lambda: len(page.nodes()) == 4)
    nodes = page.nodes()
    page.process.send_signal(signal.SIGTERM)
    assert page.process.wait(60) == 0
    assert not any(map(_is_running, nodes))
    page.close()


def test_kill_9_of_the_page_ends_the_nodes_that_it_started(domain, tmp_path):
    page = LivePage(tmp_path)
    wait_until(lambda: len(page.nodes()) == 4)
    nodes = page.nodes()
    page.process.kill()
    wait_until(lambda: not any(map(_is_running, nodes)), 30.0, 0.05)
    page.close()


def test_attached_to_nodes_it_leaves_them_alone_and_strangers_open_nothing(domain, tmp_path):
    nodes = NodeProcess(LOOPS['torque'].nodes, [], tmp_path / 'nodes.log')
    try:
        # the second address of this machine is one that needs a token
        page = LivePage(tmp_path / 'page', '--attach', '--host', '127.0.0.2')
        address = page.address.partition('?')[0]
        assert not page.nodes()
        query = '/?' + page.address.partition('?')[2]
        cookie = {'Cookie': f'mobile_robot_control_token={query.partition("=")[2]}'}
        asked = (('/', {}), (query, {}), ('/', cookie), ('/', cookie | {'Origin': 'http://evil.example'}),
                 ('/', cookie | {'Host': 'evil.example'}))
        assert [_status(address, path, **headers) for path, headers in asked] == [403, 303, 200, 403, 403]
        page.process.kill()
        page.process.wait(60)
        page.close()

        page = LivePage(tmp_path / 'again', '--attach')
        rclpy.init(args=[])
        try:
            observer = rclpy.create_node('observer')
            wait_until(lambda: ('dashboard', '/') in observer.get_node_names_and_namespaces(), 20.0, 0.05)
            # without a browser the loop does not work for the page
            assert 'dashboard' not in {end.node_name for end in observer.get_subscriptions_info_by_topic('/odom')}
        finally:
            rclpy.shutdown()
        own, foreign = page.address.rstrip('/'), 'http://evil.example'
        assert [_upgrade(page.address, origin) for origin in (own, foreign)] == [101, 403]
        assert page.stop() == 0
        page.close()
        assert nodes.exit_code() is None
    finally:
        stop_processes([nodes])


async def _send_frames(address):
    """Send frames over the page's socket that are no requests, each over a connection of its own."""
    place = address.removeprefix('http://').rstrip('/')
    for frame in ('{"do": "event"}', '{"do": {}}', '[1]', '{}', '\x1b]0;X\x07', '[' * 100_000, b'\xff',
                  'x' * (1 << 20)):
        async with websockets.connect(f'ws://{place}{SOCKET}%1b', origin=f'http://{place}') as socket:
            await socket.recv()
            await socket.send(frame)


def test_pages_that_nothing_opens_cost_nothing_and_what_is_logged_can_be_shown(domain, tmp_path):
    page = LivePage(tmp_path, '--attach')
    try:
        for _ in range(30):
            assert _status(page.address) == 200
        before = megabytes(page.process.pid)
        # as an older browser, which does not tell that another page asks
        for _ in range(150):
            assert _status(page.address) == 200
            assert _status(page.address, '/%1b]0;X%07') == 404
        assert megabytes(page.process.pid) - before < 15.0
        assert _status(page.address, Sec_Fetch_Site='cross-site', Sec_Fetch_Mode='no-cors') == 403
        asyncio.run(_send_frames(page.address))
        assert page.stop() == 0
    finally:
        page.close()
    printed = page.printed()
    assert all(line.isprintable() for line in printed.splitlines())
    assert 'Traceback' not in printed
    assert len(printed.splitlines()) <= 2


def test_an_address_that_is_none_is_refused(domain, tmp_path):
    for host, text in (('', "host = '': is no address"), (' ', 'is no address'), ('\udcff', 'cannot be served')):
        done = _run(tmp_path, '--attach', '--host', host)
        assert done.returncode == 2
        assert text in done.stderr.splitlines()[-1]
        assert 'Traceback' not in done.stderr


def test_other_publishers_are_named_and_nothing_is_started(domain, tmp_path):
    nodes = NodeProcess(LOOPS['torque'].nodes, [], tmp_path / 'nodes.log')
    try:
        wait_until(lambda: 'a run begins' in (tmp_path / 'nodes.log').read_text(), 30.0, 0.05)
        done = _run(tmp_path / 'page', '--port', '0')
        assert done.returncode == 2
        assert '--attach' in done.stderr
        # which of their topics are discovered first, DDS does not promise
        assert 'another node publishes on /' in done.stderr
    finally:
        stop_processes([nodes])
