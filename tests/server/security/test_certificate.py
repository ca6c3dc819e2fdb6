"""The self-signed certificate of a data folder, after whatever has happened to it."""

import asyncio
import datetime
import os
import socket
import ssl
import time
from pathlib import Path
from typing import Any

import pytest

from movingout.server.security import self_signed
from movingout.server.security.certificate import EARLIER, Certificate, certificate_in, host_names, keep_valid
from movingout.server.security.self_signed import names_in
from tests.server.live import serve

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


def test_one_certificate_does_in_all_networks_where_the_machine_has_been(tmp_path: Path) -> None:
    """So that no phone is asked again by a laptop that is back."""
    certificate_in(tmp_path, "192.168.1.5")
    both = certificate_in(tmp_path, "10.0.0.7").certificate.read_bytes()
    assert certificate_in(tmp_path, "192.168.1.5").certificate.read_bytes() == both
    for number in range(30):
        files = certificate_in(tmp_path, f"10.0.1.{number}")
    names = names_in(files.certificate)
    assert {"10.0.1.29", "10.0.1.28"} <= set(names) and "192.168.1.5" not in names
    assert len(names) == len(host_names("10.0.1.29")) + EARLIER


def test_a_running_server_has_a_new_certificate_before_the_old_one_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def look(renews: bool) -> None:
        assert live.server is not None
        asyncio.run_coroutine_threadsafe(live.server.look_at_certificate(renews), live.loop).result(10)

    def open_now(expected: bool) -> None:
        assert live.server is not None
        deadline = time.monotonic() + 10.0
        while live.server._connections.any_open != expected:
            assert time.monotonic() < deadline
            time.sleep(0.01)

    def served() -> str:
        return ssl.get_server_certificate(("127.0.0.1", live.port)).strip()

    certificate = certificate_in(tmp_path / "tls", HOST)
    names, old = names_in(certificate.certificate), certificate.certificate.read_text().strip()
    with serve(tmp_path, certificate=certificate) as live:
        assert "the certificate" in live.host.background._succeeded, "looked after in the background"
        look(renews=True)
        assert served() == old, "it is good for long"
        monkeypatch.setattr(self_signed, "RENEW_DAYS", 400)
        with socket.create_connection(("127.0.0.1", live.port)):  # of a page that somebody reads
            open_now(True)
            look(renews=True)
            assert served() == old, "somebody is there"
        open_now(False)
        look(renews=False)
        assert served() == old, "the process that listens makes it"
        open_now(False)
        look(renews=True)
        new = certificate.certificate.read_text().strip()
        assert served() == new != old and names_in(certificate.certificate) == names
        keep_valid(certificate, quiet=False)
        assert certificate.certificate.read_text().strip() == new, "while people play it waits until the last days"


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
