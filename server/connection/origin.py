"""Which web pages may connect: the server's own, and those that the settings list.

Browsers send Origin with every websocket handshake and every POST; programs send none and are
admitted, because they carry no one's cookies (tokens travel in messages).
"""

from collections.abc import Iterable
from urllib.parse import urlsplit

Headers = Iterable[tuple[bytes, bytes]]


def header(headers: Headers, name: bytes) -> str:
    """The value of a request header, empty when it is missing."""
    return next((value.decode("latin-1") for key, value in headers if key == name), "")


def origin_allowed(headers: Headers, scheme: str, allowed: tuple[str, ...]) -> bool:
    """Whether the Origin is absent, the requested host (`scheme` http or https), or listed."""
    origin = header(headers, b"origin")
    if not origin:
        return True
    if origin in allowed:
        return True
    host = header(headers, b"host")
    try:
        parts = urlsplit(origin)
    except ValueError:  # http://[bad
        return False
    return bool(host) and parts.netloc.lower() == host.lower() and parts.scheme == scheme
