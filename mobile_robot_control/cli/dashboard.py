"""The command `dashboard`: watch and handle the robot in a browser, with nodes of its own or those that run."""

import argparse
import contextlib
import ipaddress
import os
import secrets
import socket
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from mobile_robot_control.cli.command_parser import make_parser
from mobile_robot_control.cli.fastdds_profiles import use_fastdds_profiles
from mobile_robot_control.cli.namespace_option import add_namespace_option
from mobile_robot_control.cli.node_processes import START
from mobile_robot_control.cli.options import configuration, make_main, ros_path, whole_number
from mobile_robot_control.cli.watchdog import Watchdog
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.ros.deadline import leave_dds
from mobile_robot_control.ros.environment import check_environment
from mobile_robot_control.ros.stop import Stop
from mobile_robot_control.texts import printable

_SETTLE = 3.2
"""[s] of wall time in which other publishers are looked for before nodes are started; DDS announces every 3 s."""
_LOCAL = '127.0.0.1'


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    # before all else: a signal is not lost
    stop = Stop()
    made = make_parser('dashboard', __doc__)
    made.set_defaults(stop=stop)
    made.add_argument('--attach', action='store_true',
                      help='start no nodes: watch and handle those that run, of a real robot too')
    add_namespace_option(made, 'of the robot')
    made.add_argument('--port', type=whole_number(0, 65535), default=8080, metavar='N',
                      help='of the page; 0 takes any that is free')
    made.add_argument('--host', type=_address, default=_LOCAL, metavar='ADDRESS',
                      help='address that the page is served on; all but this machine need the token that is printed')
    made.add_argument('--output', type=ros_path, default='runs/dashboard', metavar='DIR',
                      help="folder for the nodes' logs, recordings and saved parameters")
    return made.parse_args(arguments)


def _address(text: str) -> str:
    """Read an address; an empty one would be that of all."""
    if not text.strip():
        raise argparse.ArgumentTypeError(f"'{text}' is no address; write 127.0.0.1 for this machine alone, or 0.0.0.0 "
                                         'for all addresses')
    return text


def _listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens; raise ParameterError where another program has the port."""
    try:
        return socket.create_server((host, port), family=socket.AF_INET6 if ':' in host else socket.AF_INET)
    except (OSError, TypeError, ValueError) as error:  # a name may have no encoding as a host
        number = getattr(error, 'errno', None)
        reason = os.strerror(number) if number and number > 0 else printable(str(error))
        raise ParameterError([f'{printable(host)}:{port} cannot be served ({reason}); name another --port, or a --host '
                              'that is an address of this machine']) from error


def _check_extra() -> None:
    """Raise ParameterError where the page server is not installed."""
    try:
        import nicegui  # noqa: F401, PLC0415 (an extra)
    except ModuleNotFoundError as error:
        raise ParameterError([f"the Python module {error.name} is missing; install the extra: "
                              "pip install 'mobile_robot_control[dashboard]'"]) from error


def _run(options: argparse.Namespace) -> int:
    """Serve the page until a signal comes."""
    parameters = configuration(options, options.namespace)
    _check_extra()
    folder = Path(options.output)
    (folder / 'log').mkdir(parents=True, exist_ok=True)
    check_environment(folder / 'log')
    listening = _listen(options.host, options.port)
    port = listening.getsockname()[1]
    token = '' if _is_local(options.host) else secrets.token_urlsafe(18)
    # imported late: bad usage is reported at once
    from mobile_robot_control.dashboard.actions import Actions  # noqa: PLC0415
    from mobile_robot_control.dashboard.link import RobotLink  # noqa: PLC0415
    from mobile_robot_control.dashboard.recordings import Recordings  # noqa: PLC0415
    from mobile_robot_control.dashboard.server import PageServer, Served  # noqa: PLC0415
    from mobile_robot_control.dashboard.snapshot import shown_state  # noqa: PLC0415
    from mobile_robot_control.dashboard.started_nodes import StartedNodes  # noqa: PLC0415

    with contextlib.ExitStack() as opened:
        opened.callback(listening.close)
        watchdog = opened.enter_context(Watchdog(START, name='dashboard'))
        if not options.attach:
            use_fastdds_profiles(folder / 'log')
        link = RobotLink(options.namespace, watchdog.note_progress)
        link.start()
        opened.callback(link.close)
        nodes = None
        if not options.attach:
            _refuse_others(link, options.stop)
            nodes = StartedNodes(parameters, options.namespace, folder, watchdog.note_node)
            opened.callback(nodes.stop)
            nodes.start()
        recordings = Recordings(folder / 'recordings', options.namespace)
        opened.callback(recordings.close)
        server = PageServer(
            Served(link, Actions(link, recordings, folder / 'saved'),
                   lambda: shown_state(link, nodes, recordings), folder),
            _names(options.host, *listening.getsockname()[:2]), token)
        address = f'http://{_shown(options.host)}:{port}/' + (f'?token={token}' if token else '')
        print(f'dashboard: {printable(address)} (Ctrl-C ends it)', flush=True)
        server.run(listening, lambda: options.stop.requested)
    return 0


def _refuse_others(link: object, stop: Stop) -> None:
    """Raise ParameterError where other nodes publish on the topics of the nodes that are to be started."""
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
    """Return the values of the header Host that name this page; none where any address of the machine serves it."""
    if ipaddress.ip_address(bound.partition('%')[0]).is_unspecified:
        return frozenset()
    return frozenset(f'{_shown(name)}:{port}' for name in ({_LOCAL, 'localhost', '::1'} if _is_local(host) else {host}))


_main = make_main('dashboard', _parse, _run)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code, also where to leave DDS hangs."""
    return leave_dds(int(_main(arguments)))


if __name__ == '__main__':
    sys.exit(main())
