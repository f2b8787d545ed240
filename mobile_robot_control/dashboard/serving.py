"""
The command `dashboard`: watch and control the robot live in a browser.

It starts the four nodes and prints the address of the page (docs/dashboard.md). Ctrl-C ends the page and the
nodes that it started. It needs the extra `dashboard`.

For example:
  dashboard --params-file config/fuzzy.yaml
  dashboard --attach --namespace /robot1

Exit codes:
  0  ended by Ctrl-C
  2  bad usage, a lesson with an error, a port in use, the extra is missing, or another node publishes on
     the topics of the nodes to start
"""

import argparse
import contextlib
import ipaddress
import os
import secrets
import socket
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.cli import make_dds_main, make_parser, request_of
from mobile_robot_control.dashboard.lesson_files import read_lessons
from mobile_robot_control.experiment.node_processes import START
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.parameters.requests import Reader
from mobile_robot_control.ros.shared.process import LOAD_ERRORS, Stop, check_environment, load_fault
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.files import read_namespace
from mobile_robot_control.system.files import encodable_path
from mobile_robot_control.system.supervisor import Supervisor
from mobile_robot_control.system.texts import printable

_SETTLE = 3.2
"""[s] of wall time to find other publishers before nodes are started; DDS announces every 3 s."""
_LOCAL = '127.0.0.1'
_ROBOT = 'chapter'
"""The robot of the default parameters."""


def _read_address(text: str) -> str:
    """Read an address; an empty one would mean all addresses."""
    if not text.strip():
        raise ValueError('is no address; write 127.0.0.1 for this machine alone, or 0.0.0.0 for all addresses')
    return text


class DashboardRequest(NamedTuple):
    """The request of the live page."""

    sources: ParameterSources
    attach: Annotated[bool, Field('', 'start no nodes: use running ones, of a real robot too; they go on when the '
                                  'page ends')] = False
    namespace: Annotated[str, Field('', 'namespace of the robot'), Reader(read_namespace, 'NS')] = '/'
    port: Annotated[int, Field('', 'port of the page; 0 takes any free one', minimum=0, maximum=65535)] = 8080
    host: Annotated[str, Field('', 'address of the page; other than on this machine, a visitor needs the printed '
                               'token'), Reader(_read_address, 'ADDRESS')] = _LOCAL
    lessons: Annotated[str, Field('', 'folder of your lessons, in place of the six of this package'),
                       Reader(encodable_path, 'DIR')] = ''
    check: Annotated[bool, Field('', 'check the lessons and start nothing')] = False
    output: Annotated[str, Field('', "folder for the nodes' logs, recordings and saved parameters"),
                      Reader(encodable_path, 'DIR')] = 'runs/dashboard'


def _listen(host: str, port: int) -> socket.socket:
    """Return a listening socket; raise ParameterError if another program has the port."""
    try:
        return socket.create_server((host, port), family=socket.AF_INET6 if ':' in host else socket.AF_INET)
    except (OSError, TypeError, ValueError) as error:  # a name may have no encoding as a host
        number = getattr(error, 'errno', None)
        reason = os.strerror(number) if number and number > 0 else printable(str(error))
        raise ParameterError([f'{printable(host)}:{port} cannot be served ({reason}); name another --port, or a --host '
                              'that is an address of this machine']) from error


def _check_extra() -> None:
    """Raise ParameterError if the page server is not installed."""
    try:
        for name in ('starlette', 'uvicorn', 'websockets'):
            import_module(name)
    except ModuleNotFoundError as error:
        raise ParameterError([f"the Python module {error.name} is missing; install the extra: "
                              "pip install 'mobile_robot_control[dashboard]'"]) from error


def serve(request: DashboardRequest, stop: Stop) -> None:
    """Serve the page until a stop is requested; raise ParameterError if that is impossible."""
    parameters = request.sources.configuration(request.namespace)
    lessons = read_lessons(request.lessons)
    if request.check:
        print(f'{len(lessons)} lessons: {", ".join(lesson.name for lesson in lessons)}')
        return
    _check_extra()
    folder = Path(request.output)
    (folder / 'log').mkdir(parents=True, exist_ok=True)
    check_environment(folder / 'log')
    listening = _listen(request.host, request.port)
    port = listening.getsockname()[1]
    token = '' if _is_local(request.host) else secrets.token_urlsafe(18)
    try:
        # imported late: usage errors appear at once
        from mobile_robot_control.dashboard.actions import Actions  # noqa: PLC0415
        from mobile_robot_control.dashboard.link import RobotLink  # noqa: PLC0415
        from mobile_robot_control.dashboard.recordings import Recordings  # noqa: PLC0415
        from mobile_robot_control.dashboard.server import PageServer, Served  # noqa: PLC0415
        from mobile_robot_control.dashboard.snapshot import shown_state  # noqa: PLC0415
        from mobile_robot_control.dashboard.started_nodes import StartedNodes  # noqa: PLC0415
        from mobile_robot_control.experiment.node_processes import use_fastdds_profiles  # noqa: PLC0415
    except LOAD_ERRORS as error:
        listening.close()
        raise ParameterError([load_fault(error)]) from error

    with contextlib.ExitStack() as opened:
        opened.callback(listening.close)
        supervisor = opened.enter_context(Supervisor(START, name='dashboard'))
        if not request.attach:
            use_fastdds_profiles(folder / 'log')
        link = RobotLink(request.namespace, supervisor.note_progress, None if request.attach else parameters)
        link.start()
        opened.callback(link.close)
        nodes = None
        if not request.attach:
            _refuse_others(link, stop)
            nodes = StartedNodes(parameters, request.namespace, folder, supervisor.note_node)
            opened.callback(nodes.stop)
            nodes.start()
        recordings = Recordings(folder / 'recordings', request.namespace)
        opened.callback(recordings.close)
        robot = '' if request.attach and not request.sources.robot else Path(request.sources.robot or _ROBOT).stem
        actions = Actions(link, recordings, folder / 'saved', nodes, lessons, robot, not token)
        server = PageServer(
            Served(link, actions, lambda: shown_state(link, nodes, recordings, actions), folder),
            _names(request.host, *listening.getsockname()[:2]), token)
        address = f'http://{_shown(request.host)}:{port}/' + (f'?token={token}' if token else '')
        print(f'dashboard: {printable(address)} (Ctrl-C ends it)', flush=True)
        server.run(listening, lambda: stop.requested)


def _refuse_others(link: object, stop: Stop) -> None:
    """Raise ParameterError if other nodes publish on the topics of the nodes to start."""
    deadline = time.monotonic() + _SETTLE
    while time.monotonic() < deadline and not stop.requested:
        topics = link.submit(link.loop.published).result(10.0)  # type: ignore[attr-defined]
        if topics:
            raise ParameterError([f'another node publishes on {", ".join(topics)}; watch it with --attach, or choose '
                                  'another --namespace or ROS_DOMAIN_ID'])
        time.sleep(0.1)


def _is_local(host: str) -> bool:
    return host in (_LOCAL, 'localhost', '::1')


def _shown(host: str) -> str:
    return f'[{host}]' if ':' in host else host


def _names(host: str, bound: str, port: int) -> frozenset[str]:
    """Return the values of the header Host that name this page; none if any address of the machine serves it."""
    if ipaddress.ip_address(bound.partition('%')[0]).is_unspecified:
        return frozenset()
    return frozenset(f'{_shown(name)}:{port}' for name in ({_LOCAL, 'localhost', '::1'} if _is_local(host) else {host}))


def parser() -> argparse.ArgumentParser:
    """Make the parser of `dashboard`."""
    # before all else: a signal is not lost
    stop = Stop()
    made = make_parser('dashboard', __doc__, DashboardRequest, drives=True)
    made.set_defaults(stop=stop)
    return made


def _run(options: argparse.Namespace) -> int:
    serve(request_of(DashboardRequest, options), options.stop)
    return 0


main = make_dds_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
