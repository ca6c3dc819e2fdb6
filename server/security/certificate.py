"""A self-signed certificate for play in the local network, kept so that browsers ask only once.

Gamepads need a secure context, which a page from another machine over plain HTTP is not.
"""

import datetime
import ipaddress
import os
import socket
from pathlib import Path
from typing import NamedTuple

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

VALID_DAYS = 365
RENEW_DAYS = 30


class Certificate(NamedTuple):
    """The files of a certificate."""

    certificate: Path
    key: Path


def certificate_in(folder: Path, host: str) -> Certificate:
    """The certificate of this folder, made or renewed when needed. Raises OSError."""
    files = Certificate(folder / "certificate.pem", folder / "key.pem")
    names = host_names(host)
    if not _still_good(files, names):
        folder.mkdir(parents=True, exist_ok=True)
        _make(files, names)
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


def _still_good(files: Certificate, names: list[str]) -> bool:
    try:
        certificate = x509.load_pem_x509_certificate(files.certificate.read_bytes())
    except (OSError, ValueError):
        return False
    extension = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    covered = {str(name.value) for name in extension}
    soon = datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=RENEW_DAYS)
    return files.key.is_file() and certificate.not_valid_after_utc > soon and covered >= set(names)


def _make(files: Certificate, names: list[str]) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "Moving Out Live")])
    now = datetime.datetime.now(datetime.UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(hours=1))
        .not_valid_after(now + datetime.timedelta(days=VALID_DAYS))
        .add_extension(x509.SubjectAlternativeName([_general_name(name) for name in names]), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    files.certificate.write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    with os.fdopen(os.open(files.key, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as stream:
        stream.write(
            key.private_bytes(
                serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
            )
        )


def _general_name(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)
