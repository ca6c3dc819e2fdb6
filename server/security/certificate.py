"""A self-signed certificate for play in the local network, kept so that browsers ask only once.

Gamepads need a secure context, which a page from another machine over plain HTTP is not.
"""

import socket
from pathlib import Path
from typing import NamedTuple

from movingout.maps.extras import needs_extra


class Certificate(NamedTuple):
    """The files of a certificate."""

    certificate: Path
    key: Path


def certificate_in(folder: Path, host: str) -> Certificate:
    """The certificate of this folder, made or renewed when needed. Raises OSError, and MissingExtraError."""
    with needs_extra("tls", "--tls"):
        from movingout.server.security.self_signed import make, serves
    files = Certificate(folder / "certificate.pem", folder / "key.pem")
    names = host_names(host)
    if not serves(files.certificate, files.key, names):
        folder.mkdir(parents=True, exist_ok=True)
        make(files.certificate, files.key, names)
    return files


def host_names(host: str) -> list[str]:
    """All host names of this machine."""
    names = {"localhost", "127.0.0.1", "::1", socket.gethostname(), *lan_addresses()}
    if host not in ("0.0.0.0", "::", ""):
        names.add(host)
    return sorted(names)


def lan_addresses() -> list[str]:
    """This machine's address in the local network; empty without a network.

    Connecting a datagram socket sends nothing: it only asks the routing table.
    """
    probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        probe.connect(("192.0.2.1", 9))
        address: str = probe.getsockname()[0]
    except OSError:
        return []
    finally:
        probe.close()
    return [] if address.startswith(("127.", "0.")) else [address]
