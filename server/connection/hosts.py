"""Under which names a server answers: a page of another site whose name leads here (DNS rebinding) gets nothing."""

import ipaddress
import re
import socket
import threading

from movingout.server.connection.origin import Headers, header
from movingout.server.settings import Settings

LONGEST_HOST = 260
_HOST = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._\-]+)(:\d{1,5})?")
UNKNOWN_HOST = (
    "This server does not answer under that name. Whoever runs it can add the name with --allow-host, "
    "or open it by the address that it printed at its start."
)
SEVERAL_HOSTS = "This request has several Host headers, and names one server by exactly one."


def host_refusal(headers: Headers, settings: Settings) -> tuple[int, str] | None:
    """The status and the sentence with which a request is refused for its Host; None for none.

    Of several Host headers a proxy may go by another one than this server.
    """
    headers = list(headers)
    if sum(key == b"host" for key, _ in headers) > 1:
        return 400, SEVERAL_HOSTS
    return None if host_allowed(headers, settings) else (421, UNKNOWN_HOST)


def host_allowed(headers: Headers, settings: Settings) -> bool:
    """Whether the Host of a request is one of this server's.

    Its names are those of `--allow-host`, addresses, this machine's name, and names without a dot, which nobody can
    register. Behind a trusted proxy without `--allow-host` every name is possible: the proxy knows its own.
    """
    host = header(headers, b"host")
    found = _HOST.fullmatch(host) if len(host) <= LONGEST_HOST else None
    if found is None:
        return False
    name = found[1].strip("[]").rstrip(".").lower()
    if name in settings.allowed_hosts:
        return True
    if settings.trusted_proxies and not settings.allowed_hosts:
        return True
    return "." not in name or name.endswith((".local", ".localhost")) or _is_address(name) or name in _own_names


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


_own_names = {socket.gethostname().lower()}  # what this machine calls itself, as far as known


def find_own_name() -> None:
    """Ask for the whole name of this machine, in a thread: where no DNS answers, that takes half a minute.

    Until then that name is refused: one that only begins as this machine's does may lead here from anywhere.
    """
    ask = threading.Thread(target=lambda: _own_names.add(socket.getfqdn().lower()), name="own-name", daemon=True)
    ask.start()
