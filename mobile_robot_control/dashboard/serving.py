"""A requested live page, from its nodes to its end."""

import contextlib
import secrets
import time
from importlib import import_module
from pathlib import Path

from mobile_robot_control.dashboard.lesson_files import read_lessons
from mobile_robot_control.dashboard.request import DashboardRequest, host_names, is_local, listen, shown_host
from mobile_robot_control.experiment.node_processes import START
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.ros.shared.process import LOAD_ERRORS, Stop, check_environment, load_fault
from mobile_robot_control.system.supervisor import Supervisor
from mobile_robot_control.system.texts import missing, printable

_SETTLE = 3.2
"""[s] of wall time to find other publishers before nodes are started; DDS announces every 3 s."""
_ROBOT = 'chapter'
"""The robot of the default parameters."""


def _check_extra() -> None:
    """Raise ParameterError if the page server is not installed."""
    try:
        for name in ('starlette', 'uvicorn', 'websockets'):
            import_module(name)
    except ModuleNotFoundError as error:
        raise ParameterError([missing(error.name, 'dashboard')]) from error


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
    listening = listen(request.host, request.port)
    port = listening.getsockname()[1]
    token = '' if is_local(request.host) else secrets.token_urlsafe(18)
    try:
        # imported late: usage errors appear at once
        from mobile_robot_control.dashboard.actions import Actions  # noqa: PLC0415
        from mobile_robot_control.dashboard.link import RobotLink  # noqa: PLC0415
        from mobile_robot_control.dashboard.recordings import PageRecordings  # noqa: PLC0415
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
        recordings = PageRecordings(folder / 'recordings', request.namespace)
        opened.callback(recordings.close)
        robot = '' if request.attach and not request.sources.robot else Path(request.sources.robot or _ROBOT).stem
        actions = Actions(link, recordings, folder / 'saved', nodes, lessons, robot, not token)
        server = PageServer(
            Served(link, actions, lambda: shown_state(link, nodes, recordings, actions), folder),
            host_names(request.host, *listening.getsockname()[:2]), token)
        address = f'http://{shown_host(request.host)}:{port}/' + (f'?token={token}' if token else '')
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
