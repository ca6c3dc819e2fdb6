"""Real nodes and a real HAProxy for the tests, as processes of this machine."""

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import pytest
from websockets.exceptions import WebSocketException

from movingout.server.cluster.proxy_config import ProxyConfig, ProxyLimits
from movingout.server.host import Host
from tests.server.live import Live, Person

WAIT_S = 120.0  # the machine may be busy
LEASE_S = 10.0  # of the nodes


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def wait_until(condition: Callable[[], Any], what: str) -> Any:
    deadline = time.monotonic() + WAIT_S
    while not (found := condition()):
        assert time.monotonic() < deadline, f"in vain: {what}"
        time.sleep(0.1)
    return found


def status(port: int, path: str, scheme: str = "http", **headers: str) -> int:
    """The status of a request, 0 when nobody answers."""
    request = urllib.request.Request(f"{scheme}://127.0.0.1:{port}{path}", headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=5) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        with error:
            return error.code
    except OSError:
        return 0


@dataclass
class NodeProcess:
    """`movingout play --cluster ... --node NAME`."""

    name: str
    port: int
    data: Path
    database: str
    process: "subprocess.Popen[bytes] | None" = None

    @property
    def log(self) -> Path:
        return self.data.parent / f"{self.name}.log"

    def start(self) -> None:
        command = [sys.executable, "-m", "movingout.server.cli", "play", "--port", str(self.port)]
        command += ["--data", str(self.data), "--cluster", self.database, "--node", self.name, "--countdown", "0.3"]
        command += ["--proxy", "127.0.0.1", "--agent-workers", "1", "--lease", f"{LEASE_S:g}"]
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL)

    def send(self, number: signal.Signals) -> None:
        assert self.process is not None
        os.kill(self.process.pid, number)

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        """Its exit code."""
        assert self.process is not None
        self.process.send_signal(number)
        self.process.send_signal(signal.SIGCONT)
        return self.process.wait(WAIT_S)

    @property
    def has_ended(self) -> bool:
        return self.process is not None and self.process.poll() is not None

    def is_ready(self) -> bool:
        assert self.process is not None
        assert self.process.poll() is None, self.log.read_text()
        return status(self.port, "/readyz") == 200

    def has(self, shard: str) -> bool:
        return status(self.port, f"/cluster/rooms/{shard}") == 200


def proxy_program(name: str, needed_in_ci: bool = True) -> str:
    """Fails under CI=true if it is needed there, and skips elsewhere, where a proxy is not installed."""
    found = shutil.which(name) or shutil.which(name, path="/usr/sbin:/usr/local/sbin")
    if found:
        return found
    sentence = f"{name} is not on this machine; install Debian's package {name} to run the tests with it"
    if needed_in_ci and os.environ.get("CI") == "true":
        pytest.fail(f"{sentence}, as CI=true asks for")
    pytest.skip(sentence)


def _accepts(port: int) -> bool:
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=5):
        return True
    return False


@contextmanager
def haproxy(folder: Path, nodes: Sequence[NodeProcess], **config: Any) -> Iterator[Live]:
    """A proxy on a free port for one `with` block; the server that people reach through it."""
    program, port = proxy_program("haproxy"), free_port()
    file = folder / f"haproxy-{port}.cfg"
    written = ProxyConfig(
        nodes={node.name: f"127.0.0.1:{node.port}" for node in nodes},
        listen=f"127.0.0.1:{port}",
        **{"limits": ProxyLimits(connections=300), **config},
    )
    file.write_text(written.text("haproxy"), encoding="utf-8")
    checked = subprocess.run([program, "-c", "-f", str(file)], check=True, capture_output=True, text=True, timeout=60)
    assert "WARNING" not in checked.stderr, checked.stderr
    with (folder / "haproxy.log").open("ab") as log:
        process = subprocess.Popen([program, "-f", str(file)], stdout=log, stderr=log)
    live = Live(port, cast(Host, None), cast(Any, None))
    try:
        wait_until(lambda: _accepts(port), "the proxy listens")
        yield live
    finally:
        live.hang_up()
        process.kill()
        process.wait()


@contextmanager
def caddy(folder: Path, nodes: Sequence[NodeProcess], certificate: str = "") -> Iterator[Live]:
    """The same with Caddy, without https where there is no certificate."""
    program, port = proxy_program("caddy", needed_in_ci=False), free_port()
    file = folder / f"Caddyfile-{port}"
    written = ProxyConfig(
        nodes={node.name: f"127.0.0.1:{node.port}" for node in nodes},
        listen=f"http{'s' * bool(certificate)}://127.0.0.1:{port}",
        certificate=certificate,
    )
    options = "{\n\tadmin off\n\tauto_https disable_redirects\n\tskip_install_trust\n"
    file.write_text(written.text("caddy").replace("{\n", options, 1), encoding="utf-8")
    own = {**os.environ, "HOME": str(folder), "XDG_DATA_HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
    command = [program, "run", "--adapter", "caddyfile", "--config", str(file)]
    with (folder / "caddy.log").open("ab") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, env=own)
    live = Live(port, cast(Host, None), cast(Any, None))
    try:
        wait_until(lambda: _accepts(port), "the proxy listens")
        yield live
    finally:
        live.hang_up()
        process.kill()
        process.wait()


def come_back(live: Live, room: str, token: str) -> Person:
    """The same person again, who tries as pages do."""

    def attempt() -> Person | None:
        with contextlib.suppress(OSError, WebSocketException, AssertionError):
            return live.person(room, tokens=[token])
        return None

    person: Person = wait_until(attempt, f"room {room} goes on")
    person.say(type="ready", seat=0, ready=True)
    return person
