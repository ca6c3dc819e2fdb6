"""The self-signed certificate of a data folder, after whatever has happened to it."""

import datetime
import os
import ssl
from pathlib import Path
from typing import Any

import pytest

from movingout.server.security.certificate import Certificate, certificate_in

HOST = "127.0.0.1"


def load(files: Certificate) -> None:
    """What a server does with it at its start."""
    ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(files.certificate, files.key)


@pytest.mark.parametrize("name", ["certificate.pem", "key.pem"])
@pytest.mark.parametrize(
    "content", [b"", b"-----BEGIN PRIVATE KEY-----\n", None], ids=["empty", "cut off", "another's"]
)
def test_files_that_do_not_belong_together_are_made_anew(tmp_path: Path, name: str, content: bytes | None) -> None:
    other = certificate_in(tmp_path / "other", HOST)
    files = certificate_in(tmp_path / "tls", HOST)
    (tmp_path / "tls" / name).write_bytes((other.key.parent / name).read_bytes() if content is None else content)
    certificate_in(tmp_path / "tls", HOST)
    load(files)


def test_a_disk_that_is_full_while_it_is_made_leaves_what_the_next_start_can_use(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    files = certificate_in(tmp_path, HOST)
    with monkeypatch.context() as while_full:
        while_full.setattr(os, "fsync", full)
        with pytest.raises(OSError, match="No space left"):
            certificate_in(tmp_path, "10.1.2.3")
    load(files)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["certificate.pem", "key.pem"]
    load(certificate_in(tmp_path, "10.1.2.3"))


def test_one_of_the_future_is_made_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As by a machine whose clock was wrong at first."""

    class Ahead(datetime.datetime):
        """The clock of a machine, a month ahead."""

        @classmethod
        def now(cls, tz: Any = None) -> "Ahead":
            return super().now(tz) + datetime.timedelta(days=30)

    with monkeypatch.context() as ahead:
        ahead.setattr(datetime, "datetime", Ahead)
        first = certificate_in(tmp_path, HOST).certificate.read_bytes()
    second = certificate_in(tmp_path, HOST).certificate.read_bytes()
    assert second != first
    assert certificate_in(tmp_path, HOST).certificate.read_bytes() == second
