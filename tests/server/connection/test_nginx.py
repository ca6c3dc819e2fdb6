"""A server behind a real nginx, configured as docs/deploy.md says."""

import contextlib
import getpass
import http.client
import json
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.server.cluster.processes import free_port, proxy_program
from tests.server.live import WAIT_S, Live, raw_socket, serve, wait_until

DOCS = Path(__file__).parents[3] / "docs" / "deploy.md"
CLIENT = "127.0.0.2"


def written(port: int, served: int, folder: Path) -> str:
    """A whole configuration around the lines of the documentation."""
    (lines,) = re.findall(r"```nginx\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    variables, location = lines.split("location /", 1)
    location = f"location /{location}".replace("127.0.0.1:8000", f"127.0.0.1:{served}")
    kinds = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    paths = "".join(f"{kind}_temp_path {folder}/{kind};\n" for kind in kinds)
    user = "user root;" if getpass.getuser() == "root" else ""  # else its processes may not write into the folder
    return (
        f"daemon off; {user} pid {folder}/pid; error_log {folder}/error.log; events {{ }}\n"
        f"http {{ access_log off;\n{paths}{variables}server {{ listen 127.0.0.1:{port};\n{location}}} }}\n"
    )


@pytest.fixture
def live(tmp_path: Path) -> Iterator[Live]:
    """A server, reached through nginx."""
    program, port = proxy_program("nginx", needed_in_ci=False), free_port()
    with serve(tmp_path / "data", trusted_proxies=("127.0.0.1",)) as served:
        file = tmp_path / "nginx.conf"
        file.write_text(written(port, served.port, tmp_path), encoding="utf-8")
        process = subprocess.Popen([program, "-p", str(tmp_path), "-e", str(tmp_path / "error.log"), "-c", str(file)])
        live = Live(port, served.host, served.loop, server=served.server)
        try:
            wait_until(lambda: _accepts(live))
            yield live
        finally:
            live.hang_up()
            process.terminate()
            process.wait()


def _accepts(live: Live) -> bool:
    try:
        raw_socket(live).close()
    except OSError:
        return False
    return True


def asked(live: Live, path: str, body: bytes = b"", **headers: str) -> tuple[int, dict[str, Any]]:
    """Status and JSON of a request from CLIENT."""
    connection = http.client.HTTPConnection("127.0.0.1", live.port, timeout=WAIT_S, source_address=(CLIENT, 0))
    with contextlib.closing(connection):
        connection.request("POST", path, body, {name.replace("_", "-"): value for name, value in headers.items()})
        answer = connection.getresponse()
        return answer.status, json.loads(answer.read())


@pytest.mark.slow
def test_a_page_behind_nginx_plays(live: Live) -> None:
    room = live.open_room("here", "idle", limit_ticks=12)
    connection = live.connect(
        room["room"], origin=f"http://{live.address}"
    )  # as a browser: the Host has to be the same
    connection.close()
    person = live.person(room["room"], tokens=room["tokens"][:1])
    person.say(type="ready", seat=0)
    assert person.play_out()["ticks"] == 12


@pytest.mark.slow
def test_an_address_behind_nginx_is_the_one_that_connected(live: Live) -> None:
    wanted = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]}
    status, room = asked(live, "/api/rooms", json.dumps(wanted).encode(), X_Forwarded_For="203.0.113.9")
    assert status == 200
    assert live.host.admission.rooms_of(CLIENT) == {room["room"]}


@pytest.mark.slow
def test_a_body_behind_nginx_is_as_long_as_the_server_allows(live: Live) -> None:
    most = live.host.settings.limits.body_bytes
    for size, code in ((most, "bad_request"), (most + 1, "too_large")):
        assert asked(live, "/api/rooms", b"x" * size)[1]["error"]["code"] == code
