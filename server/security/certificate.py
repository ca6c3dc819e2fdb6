"""A self-signed certificate for play in the local network, kept over changes of network so that browsers ask only once.

Gamepads need a secure context, which a page from another machine over plain HTTP is not.
"""

import socket
from pathlib import Path
from typing import NamedTuple

from movingout.maps.extras import needs_extra

EARLIER = 20  # names of other networks that are kept, the newest first


class Certificate(NamedTuple):
    """The files of a certificate."""

    certificate: Path
    key: Path


def certificate_in(folder: Path, host: str) -> Certificate:
    """The certificate of this folder, made or renewed when needed. Raises OSError, and MissingExtraError."""
    with needs_extra("tls", "--tls"):
        from movingout.server.security.self_signed import make, names_in, serves
    files = Certificate(folder / "certificate.pem", folder / "key.pem")
    names = host_names(host)
    if not serves(files.certificate, files.key, names):
        folder.mkdir(parents=True, exist_ok=True)
        earlier = [name for name in names_in(files.certificate) if name not in names]
        make(files.certificate, files.key, [*names, *earlier[:EARLIER]])
    return files


def keep_valid(files: Certificate, quiet: bool) -> None:
    """Make the certificate of a running server anew, with the same names, before it ends: best while nobody is there.

    Pages that are open have to be loaded again then. Raises OSError.
    """
    from movingout.server.security.self_signed import LAST_DAYS, RENEW_DAYS, days_left, make, names_in

    names = names_in(files.certificate)
    if names and days_left(files.certificate) < (RENEW_DAYS if quiet else LAST_DAYS):
        make(files.certificate, files.key, names)


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
