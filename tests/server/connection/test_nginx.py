"""A server behind a real nginx, configured as docs/deploy.md says."""

import contextlib
import getpass
import http.client
import json
import re
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.server.cluster.processes import free_port, proxy_program
from tests.server.live import WAIT_S, Live, serve, wait_until

DOCS = Path(__file__).parents[3] / "docs" / "deploy.md"
CLIENT = "127.0.0.2"


def written(port: int, served: int, folder: Path) -> str:
    """A whole configuration around the lines of the documentation."""
    (lines,) = re.findall(r"```nginx\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    variables, location = lines.split("location /", 1)
    location = f"location /{location}".replace("127.0.0.1:8000", f"127.0.0.1:{served}")
    location = location.replace("/var/log/nginx", str(folder))
    kinds = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    paths = "".join(f"{kind}_temp_path {folder}/{kind};\n" for kind in kinds)
    user = "user root;" if getpass.getuser() == "root" else ""  # else its processes may not write into the folder
    return (
        f"daemon off; {user} pid {folder}/pid; error_log {folder}/error.log; events {{ }}\n"
        f"http {{ access_log {folder}/access.log;\n{paths}{variables}"
        f"server {{ listen 127.0.0.1:{port};\n{location}}} }}\n"
    )


@contextlib.contextmanager
def nginx(folder: Path, served: int) -> Iterator[int]:
    """The port of an nginx before the port `served`."""
    program, port = proxy_program("nginx", needed_in_ci=False), free_port()
    file = folder / "nginx.conf"
    file.write_text(written(port, served, folder), encoding="utf-8")
    process = subprocess.Popen([program, "-p", str(folder), "-e", str(folder / "error.log"), "-c", str(file)])
    try:
        wait_until(lambda: _accepts(port))
        yield port
    finally:
        process.terminate()
        process.wait()


@pytest.fixture
def live(tmp_path: Path) -> Iterator[Live]:
    """A server, reached through nginx."""
    with (
        serve(tmp_path / "data", trusted_proxies=("127.0.0.1",)) as served,
        nginx(tmp_path, served.port) as port,
    ):
        live = Live(port, served.host, served.loop, server=served.server)
        yield live
        live.hang_up()


def _accepts(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), WAIT_S).close()
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


def test_who_takes_part_in_a_study_is_in_no_log_of_nginx_nor_where_the_server_is_away(tmp_path: Path) -> None:
    with nginx(tmp_path, free_port()) as port:
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=WAIT_S)
        with contextlib.closing(connection):
            link = "/study?id=Ann&sig=abcdef"
            connection.request("GET", link, headers={"Referer": f"http://127.0.0.1:{port}{link}"})
            assert connection.getresponse().status == 502
    logs = sorted(tmp_path.glob("*.log"))
    assert logs and not any("abcdef" in log.read_text(encoding="utf-8") for log in logs)
