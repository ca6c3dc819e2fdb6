"""Making a self-signed certificate; needs `cryptography`."""

import datetime
import ipaddress
import os
import ssl
import tempfile
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

VALID_DAYS = 365
RENEW_DAYS = 30
LAST_DAYS = 3  # then it is made anew while people play, too


def serves(file: Path, key_file: Path, names: list[str]) -> bool:
    """Whether a certificate is there with its key, holds these names, and is good now and for another month."""
    try:
        # A key with a password is none of ours; without the answer OpenSSL would ask for it at the terminal.
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(file, key_file, password="")
        certificate = x509.load_pem_x509_certificate(file.read_bytes())
    except (OSError, ValueError):
        return False
    begun = certificate.not_valid_before_utc <= datetime.datetime.now(datetime.UTC)
    return begun and days_left(file) > RENEW_DAYS and set(names_in(file)) >= set(names)


def names_in(file: Path) -> list[str]:
    """The names that a certificate holds, in its order; none of a file that is no certificate."""
    try:
        certificate = x509.load_pem_x509_certificate(file.read_bytes())
        extension = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (OSError, ValueError, x509.ExtensionNotFound):
        return []
    return [str(name.value) for name in extension if isinstance(name, x509.DNSName | x509.IPAddress)]


def days_left(file: Path) -> float:
    """Raises OSError and ValueError."""
    end = x509.load_pem_x509_certificate(file.read_bytes()).not_valid_after_utc
    return (end - datetime.datetime.now(datetime.UTC)) / datetime.timedelta(days=1)


def make(file: Path, key_file: Path, names: list[str]) -> None:
    """Write a certificate of these names and its key, which only their owner can read. Raises OSError.

    The key comes first: whatever happens in between, the certificate is no use without it and is made anew.
    """
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
    form = serialization.PrivateFormat.PKCS8
    _keep(key_file, key.private_bytes(serialization.Encoding.PEM, form, serialization.NoEncryption()))
    _keep(file, certificate.public_bytes(serialization.Encoding.PEM))


def _keep(file: Path, content: bytes) -> None:
    """Write atomically, and never readable by others."""
    descriptor, part = tempfile.mkstemp(prefix=f".{file.name}-", dir=file.parent)  # mode 0600
    try:
        with open(descriptor, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(part, file)
    except OSError:
        os.unlink(part)
        raise


def _general_name(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)
