"""Requested live pages, and the addresses at which they are served."""

import ipaddress
import os
import socket
from typing import Annotated, NamedTuple

from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.parameters.requests import Reader
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.files import read_namespace
from mobile_robot_control.system.files import encodable_path
from mobile_robot_control.system.texts import printable

_LOCAL = '127.0.0.1'


def _read_address(address: str) -> str:
    """Read an address; an empty one would mean all addresses."""
    if not address.strip():
        raise ValueError('is no address; write 127.0.0.1 for this machine alone, or 0.0.0.0 for all addresses')
    return address


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


def listen(host: str, port: int) -> socket.socket:
    """Return a listening socket; raise ParameterError if another program has the port."""
    try:
        return socket.create_server((host, port), family=socket.AF_INET6 if ':' in host else socket.AF_INET)
    except (OSError, TypeError, ValueError) as error:  # a name may have no encoding as a host
        number = getattr(error, 'errno', None)
        reason = os.strerror(number) if number and number > 0 else printable(str(error))
        raise ParameterError([f'{printable(host)}:{port} cannot be served ({reason}); name another --port, or a --host '
                              'that is an address of this machine']) from error


def is_local(host: str) -> bool:
    """Return whether a host means this machine alone."""
    return host in (_LOCAL, 'localhost', '::1')


def shown_host(host: str) -> str:
    """Return a host as it stands in an address."""
    return f'[{host}]' if ':' in host else host


def host_names(host: str, bound: str, port: int) -> frozenset[str]:
    """Return the values of the header Host that name this page; none if any address of the machine serves it."""
    if ipaddress.ip_address(bound.partition('%')[0]).is_unspecified:
        return frozenset()
    names = {_LOCAL, 'localhost', '::1'} if is_local(host) else {host}
    return frozenset(f'{shown_host(name)}:{port}' for name in names)
