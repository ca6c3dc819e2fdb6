"""Which web pages may talk to this server: its own, and those that the settings name.

Browsers send Origin with every websocket handshake and every POST; programs send none and are let in, because they
carry no cookies of anybody (tokens travel in messages).
"""

from collections.abc import Iterable
from urllib.parse import urlsplit

Headers = Iterable[tuple[bytes, bytes]]


def header(headers: Headers, name: bytes) -> str:
    """The value of a request header, empty when it is missing."""
    return next((value.decode("latin-1") for key, value in headers if key == name), "")


def origin_allowed(headers: Headers, scheme: str, allowed: tuple[str, ...]) -> bool:
    """Whether the Origin is absent, the host that was asked for (`scheme` http or https), or in the list."""
    origin = header(headers, b"origin")
    if not origin:
        return True
    if origin in allowed:
        return True
    host = header(headers, b"host")
    parts = urlsplit(origin)
    return bool(host) and parts.netloc.lower() == host.lower() and parts.scheme == scheme
