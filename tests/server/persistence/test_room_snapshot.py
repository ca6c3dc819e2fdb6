"""A real `movingout play`: killed, started again, stopped, refused. Nothing is lost but the tick in flight."""

import json
import random
import re
import signal
import socket
import ssl
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from movingout.recordings import read_episode, verify
from movingout.server import messages as m
from movingout.server.cli import main
from movingout.server.uvicorn_server import listen
from tests.server.live import Live, Person

pytestmark = pytest.mark.slow

COMMAND = [sys.executable, "-m", "movingout.server.cli", "play", "--countdown", "0.3", "--processes", "1"]


@dataclass
class Program:
    """A running `movingout play`."""

    process: "subprocess.Popen[str]"
    live: Live
    admin_token: str
    printed: str


def free_port() -> int:
    with listen("127.0.0.1", 0) as free:
        return int(free.getsockname()[1])


@contextmanager
def program(data: Path, port: int, *options: str) -> Iterator[Program]:
    """The server as people start it; killed at the end of the block if it still runs."""
    command = [*COMMAND, "--port", str(port), "--data", str(data), *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            printed = ""
            while "Data" not in printed:
                line = process.stdout.readline()
                assert line, process.stderr and process.stderr.read()
                printed += line
            found = re.search(r"Admin token\s+in (.+)", printed)
            assert found
            token = Path(found[1]).read_text().strip()
            yield Program(process, Live(port, None, None), token, printed)  # type: ignore[arg-type]
        finally:
            process.kill()
            process.wait(20)


def start_game(live: Live, limit_ticks: int) -> tuple[str, Person, Person]:
    room = live.open_room("here", "link", limit_ticks=limit_ticks)
    blue = live.person(room["room"], tokens=[room["tokens"][0]])
    red = live.person(room["room"], claim=1)
    blue.say(type="ready", seat=0)
    red.say(type="ready", seat=1)
    blue.wait_for("room", phase="playing")
    return room["room"], blue, red


def play_on(blue: Person, red: Person, ticks: int) -> int:
    """Both play so many ticks; the last one."""
    tick = 0
    for _ in range(ticks):
        tick = blue.next_tick(0)
        red.next_tick(1)
    return tick


def read_to_the_end(person: Person) -> None:
    try:
        while True:
            person.hear(2)
    except (ConnectionClosed, TimeoutError, OSError):
        pass


def kill_and_return(tmp_path: Path, kills: list[int], limit_ticks: int, *options: str) -> None:
    """Play, killing the server after so many ticks each time, and end the round; check what was recorded."""
    port = free_port()
    room, tokens, seen = "", [["", ""], ["", ""]], 0
    for turn, ticks in enumerate([*kills, 0]):
        with program(tmp_path, port, *options) as running:
            live = running.live
            if not turn:
                room, blue, red = start_game(live, limit_ticks)
            else:
                blue, red = live.person(room, tokens=tokens[0]), live.person(room, tokens=tokens[1])
                paused = blue.wait_for("room")
                assert paused["phase"] in ("paused", "countdown")
                first = blue.next_tick(0)
                red.next_tick(1)
                assert seen < first <= seen + 2, "play goes on after the last recorded tick"
            if ticks:
                play_on(blue, red, ticks)
                running.process.send_signal(signal.SIGKILL)
                running.process.wait(20)
                read_to_the_end(blue)
                read_to_the_end(red)
                seen = max(blue.bundles[-1].tick, red.bundles[-1].tick)
                tokens = [blue.tokens, red.tokens]
            else:
                while not (results := blue.results()):
                    blue.answer_one(0)
                    red.answer_one(1)
                (result,) = results
                assert (result["outcome"], result["ticks"]) == ("time", limit_ticks)
                assert live.call(f"/api/recordings/{result['recording']}")[1]["exact"]
            live.hang_up()
    (recording,) = (tmp_path / "recordings").glob("*")
    episode = read_episode(recording)
    assert (len(episode.ticks), episode.outcome, episode.complete) == (limit_ticks, "time", True)
    assert verify(recording).identical
    assert sum(event.kind == "resume" for event in episode.events) == len(kills)


def test_after_kill_9_the_same_people_play_on_where_they_were(tmp_path: Path) -> None:
    kill_and_return(tmp_path, [7], limit_ticks=20)


def test_the_same_with_several_processes(tmp_path: Path) -> None:
    kill_and_return(tmp_path, [7], 20, "--processes", "2")


def test_ten_kills_at_random_ticks_lose_nothing_but_the_tick_in_flight(tmp_path: Path) -> None:
    kills = random.Random(9).choices(range(1, 25), k=10)
    kill_and_return(tmp_path, kills, limit_ticks=sum(kills) + 60)


def test_sigterm_says_goodbye_exits_with_0_and_the_round_goes_on_after_it(tmp_path: Path) -> None:
    port = free_port()
    with program(tmp_path, port) as running:
        room, blue, red = start_game(running.live, 30)
        tick = play_on(blue, red, 4)
        running.process.terminate()
        code, told = blue.end()
        assert (code, told[-1]["type"]) == (m.CLOSE_SHUTDOWN, "bye")
        assert running.process.wait(30) == 0
        assert running.process.stdout is not None
        assert "1 round was interrupted; it goes on when the server is started again" in running.process.stdout.read()
        running.live.hang_up()
        tokens = blue.tokens + red.tokens
    with program(tmp_path, port) as running:
        blue, red = (running.live.person(room, tokens=[token]) for token in tokens)
        blue.say(type="ready", seat=0)
        red.say(type="ready", seat=1)
        assert blue.next_tick(0) > tick - 2, "no tick that was seen is played again"
        blue.wait_for("result")
        running.process.terminate()
        assert running.process.wait(30) == 0
        running.live.hang_up()
    (recording,) = (tmp_path / "recordings").iterdir()
    episode = read_episode(recording)
    assert (recording.suffix, episode.outcome, len(episode.ticks)) == (".mcap", "time", 30)
    assert verify(recording).identical


def test_a_second_server_on_the_same_data_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with program(tmp_path, free_port()) as running:
        start_game(running.live, 500)
        rooms = sorted((tmp_path / "rooms").iterdir())
        assert main(["play", "--port", "0", "--data", str(tmp_path)]) == 2
        assert "in use by another server; stop that one or choose another: --data DIR" in capsys.readouterr().err
        assert sorted((tmp_path / "rooms").iterdir()) == rooms
        running.live.hang_up()


def test_games_are_not_served_from_the_folder_of_a_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "studies" / "tower").mkdir(parents=True)
    (tmp_path / "studies" / "tower" / "study.sqlite").touch()
    assert main(["play", "--port", "0", "--data", str(tmp_path)]) == 2
    refusal = capsys.readouterr().err
    assert "holds a study (tower)" in refusal and "movingout study serve" in refusal


def test_the_links_are_printed_and_work(tmp_path: Path) -> None:
    port = free_port()
    with program(tmp_path, port) as running:
        for name in ("Play", "Watch", "Recordings", "Admin"):
            assert re.search(rf"{name}\s+http://127.0.0.1:{port}/", running.printed), name
        assert running.live.call("/")[0] == 200
        assert running.live.call("/api/admin/state", token=running.admin_token)[0] == 200


def test_tls_serves_pages_and_sockets_with_the_kept_certificate(tmp_path: Path) -> None:
    port = free_port()
    with program(tmp_path, port, "--tls") as running:
        assert f"https://127.0.0.1:{port}/" in running.printed
        context = ssl.create_default_context(cafile=str(tmp_path / "tls" / "certificate.pem"))
        with urllib.request.urlopen(f"https://127.0.0.1:{port}/healthz", context=context, timeout=20) as answer:
            assert json.load(answer)["ok"]
        with connect(
            f"wss://127.0.0.1:{port}/ws",
            subprotocols=[m.SUBPROTOCOL],  # type: ignore[list-item]
            ssl=context,
            origin=f"https://127.0.0.1:{port}",  # type: ignore[arg-type]
        ) as connection:
            connection.send(json.dumps({"type": "join", "room": "nowhere"}))
            assert json.loads(connection.recv(20))["code"] == m.CLOSE_NOT_FOUND


def test_journals_that_others_left_behind_are_finished_at_start_up(tmp_path: Path) -> None:
    port = free_port()
    with program(tmp_path, port) as running:
        room, blue, red = start_game(running.live, 500)
        play_on(blue, red, 3)
        running.process.send_signal(signal.SIGKILL)
        running.process.wait(20)
        running.live.hang_up()
    token = running.admin_token
    (tmp_path / "rooms" / f"{room}.json").unlink()
    (journal,) = (tmp_path / "recordings").glob("*.journal")
    episode_id = journal.name.removesuffix(".mcap.journal")
    with program(tmp_path, port) as running:
        assert running.admin_token == token, "links and open pages outlive a restart"
        _, summary = running.live.call(f"/api/recordings/{episode_id}")
    assert (summary["outcome"], summary["complete"]) == ("interrupted", False)
    assert summary["ticks"] >= 3


def refused(*options: str) -> str:
    """What a start that cannot work says, with exit code 2 and no traceback."""
    ended = subprocess.run([*COMMAND, *options], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 2, ended
    assert "Traceback" not in ended.stderr
    return ended.stderr


def test_a_port_in_use_is_told_with_what_would_work(tmp_path: Path) -> None:
    with listen("127.0.0.1", 0) as taken:
        port = taken.getsockname()[1]
        assert f"--port {port + 1}" in refused("--port", str(port), "--data", str(tmp_path))


def test_an_address_that_is_not_ours_is_told(tmp_path: Path) -> None:
    assert "127.0.0.1" in refused("--host", "192.0.2.7", "--port", "0", "--data", str(tmp_path))
    assert "a port is a number from 0 to 65535, not 99999" in refused("--port", "99999", "--data", str(tmp_path))


def test_a_data_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    assert "--data DIR" in refused("--data", str(file))
    assert "--data DIR" in refused("--data", "/proc/nowhere")


def test_an_unknown_partner_is_told_with_the_known_ones(tmp_path: Path) -> None:
    assert "known: scripted" in refused("--partner", "skripted", "--data", str(tmp_path))


@pytest.mark.parametrize("seconds", ["-1", "61", "nan"])
def test_a_countdown_that_makes_no_sense_is_told(seconds: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["play", "--countdown", seconds])
    assert "from 0 to 60 seconds are possible" in capsys.readouterr().err


def test_accepted_connections_have_small_buffers() -> None:
    with listen("127.0.0.1", 0) as listening:
        listening.setblocking(True)
        with socket.create_connection(listening.getsockname()) as _, listening.accept()[0] as accepted:
            assert accepted.getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF) <= 2 * 32 * 1024
            assert accepted.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) <= 2 * 8 * 1024


@pytest.mark.parametrize("command", [["play"], ["study", "serve", "study.yaml"]], ids=["play", "study"])
@pytest.mark.parametrize("count", ["0", "-1", "65", "many"])
def test_a_number_of_agent_processes_that_cannot_be_is_refused(
    command: list[str], count: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as refused:
        main([*command, f"--agent-workers={count}"])
    assert refused.value.code == 2
    assert f"from 1 to 64 processes are possible, not {count}" in capsys.readouterr().err
