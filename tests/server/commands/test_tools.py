"""doctor, loadtest and the certificate."""

import json
import re
import signal
import ssl
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from movingout.agents.catalogue import agent_card, agent_cards
from movingout.server.cli import main
from movingout.server.commands import doctor, loadtest
from movingout.server.commands.doctor import examine
from movingout.server.commands.exactness_probe import PROBES, Probe, deviation
from movingout.server.commands.loadtest import LoadTestError, RunningServer, measure
from movingout.server.commands.with_parent import PROGRAM
from movingout.server.notices import NOTHING, Notice
from movingout.server.public_host import PublicHost
from movingout.server.security.certificate import certificate_in, host_names
from movingout.server.uvicorn_server import listen
from movingout.world.exactness import inexact_engine
from tests.server.live import ADMIN, Live


@pytest.mark.slow
def test_a_healthy_machine_has_no_faults(tmp_path: Path) -> None:
    answers = {answer.question: answer for answer in examine(0, tmp_path)}
    assert [answer for answer in answers.values() if answer.grade == "fault"] == []
    assert answers["exactness"].grade in ("ok", "note")
    for card in agent_cards():  # each is loaded and plays
        assert re.search(r"\d+ decisions in 100 ticks, p99 \d+\.\d ms", answers[card.id].sentence)


def test_doctor_finds_an_agent_that_cannot_be_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "agent_cards", lambda: [agent_card("idle")])
    monkeypatch.setattr(doctor, "damaged_cards", lambda: ["the checkpoint dp@mine is damaged"])
    (idle, damaged) = examine(0, tmp_path)[-2:]
    assert (idle.question, idle.grade) == ("idle", "ok")
    assert (damaged.grade, damaged.sentence) == ("fault", "the checkpoint dp@mine is damaged")


@pytest.mark.slow
def test_doctor_says_in_one_line_when_the_physics_are_not_exact(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    x, *rest = PROBES[1].poses
    other = PROBES[1]._replace(poses=(x + 1e-9, *rest))
    monkeypatch.setattr(doctor, "PROBES", (PROBES[0], other))
    exactness = next(finding for finding in examine(0, tmp_path) if finding.question == "exactness")
    assert exactness.grade == "note"
    assert exactness.sentence.startswith("the physics are not exact here: a large item ends 1.0e-09 away")
    assert "\n" not in exactness.sentence


@pytest.mark.parametrize("probe", PROBES, ids=lambda probe: str(probe.map))
def test_the_probes_end_where_the_tested_engine_ends(probe: Probe) -> None:
    assert inexact_engine() is not None or deviation(probe) == 0.0


def test_doctor_says_which_data_folder_cannot_be_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "agent_cards", list)
    findings = {finding.question: finding for finding in examine(0, tmp_path / ("x" * 300))}
    assert findings["data folder"].grade == "fault" and "File name too long" in findings["data folder"].sentence
    assert len(findings) > 5, "beside what else was found"


@pytest.mark.slow
def test_doctor_says_what_is_wrong(tmp_path: Path) -> None:
    with listen("127.0.0.1", 0) as taken:
        answers = {answer.question: answer for answer in examine(taken.getsockname()[1], Path("/proc/nowhere"))}
    assert answers["port"].grade == "note" and "in use" in answers["port"].sentence
    assert answers["data folder"].grade == "fault" and "--data DIR" in answers["data folder"].sentence


@pytest.mark.slow
def test_doctor_prints_one_json_document(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "movingout.server.cli", "doctor", "--json", "--port", "0", "--data", str(tmp_path)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=180)
    report = json.loads(ended.stdout)
    assert (ended.returncode, report["healthy"]) == (0, True)


def _measured(target: RunningServer, rooms: int, clients: int, seconds: float) -> dict[str, Any]:
    """In a thread of its own: the browser tests leave an event loop running in the main one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(measure, target, rooms, clients, seconds).result()


@pytest.mark.slow
def test_the_load_test_has_its_fixed_fields(live: Live) -> None:
    before = live.rooms
    result = _measured(RunningServer(f"http://{live.address}", ADMIN), rooms=2, clients=3, seconds=1.5)
    assert {
        "rooms", "clients", "seconds", "ticks", "missed_ticks", "late_ms", "bytes_per_client_s", "cpu_percent",
        "rss_mb", "deadline_misses",
    } <= set(result)  # fmt: skip
    assert set(result["late_ms"]) == {"p50", "p99", "p999", "max"}
    assert result["client_gaps"] == 0
    assert result["bundles"] >= 6, "every client has seen play"
    assert result["closed"] == {}
    assert live.rooms == before, "none was left open"


def test_the_load_test_opens_rooms_for_programs(live: Live) -> None:
    """Recorded as a person's, the play of its clients was learned from."""
    target = RunningServer(f"http://{live.address}", ADMIN)
    opened = {clients: loadtest.open_room(target, "Simple", clients) for clients in (1, 2)}
    seats = {room.id: [seat.kind for seat in room.seats] for room in live.rooms}
    assert {clients: seats[room] for clients, room in opened.items()} == {1: ["remote", "idle"], 2: ["remote"] * 2}


@pytest.mark.slow
def test_the_load_test_waits_for_a_server_that_is_busy_for_a_moment(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = iter([Notice("busy", "The server is busy, and running games come first; try again later.")] * 2)
    monkeypatch.setattr(PublicHost, "refusal", lambda *_, **__: next(answers, NOTHING))
    result = _measured(RunningServer(f"http://{live.address}", ADMIN), rooms=1, clients=2, seconds=0.5)
    assert result["rooms"] == 1
    assert next(answers, None) is None, "it was refused twice"
    monkeypatch.setattr(loadtest, "BUSY_LIMIT_S", 0.0)
    monkeypatch.setattr(PublicHost, "refusal", lambda *_, **__: Notice("busy", "The server is busy."))
    with pytest.raises(LoadTestError, match="busy"):
        _measured(RunningServer(f"http://{live.address}", ADMIN), rooms=1, clients=2, seconds=0.5)


def test_the_load_test_needs_the_admin_token_of_a_foreign_server(live: Live) -> None:
    """It asked for it after all rooms had been opened, filled and recorded."""
    before = live.rooms
    for token, code in (("", 401), ("wrong", 403)):
        with pytest.raises(LoadTestError, match=f"answers {code}: .* Give it by --admin-token; it is in the file"):
            _measured(RunningServer(f"http://{live.address}", token), rooms=1, clients=1, seconds=1)
    assert live.rooms == before
    with pytest.raises(LoadTestError, match="does not answer"):
        _measured(RunningServer("http://127.0.0.1:1", ""), rooms=1, clients=1, seconds=1)


def test_the_load_test_leaves_no_room_open_where_not_all_could_be_opened(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = live.rooms
    opened: list[str] = []

    def open_one(target: RunningServer, *rest: Any) -> str:
        if opened:
            raise LoadTestError("there is no more room")
        opened.append(loadtest_opens(target, *rest))
        return opened[-1]

    loadtest_opens = loadtest.open_room
    monkeypatch.setattr(loadtest, "open_room", open_one)
    with pytest.raises(LoadTestError, match="no more room"):
        _measured(RunningServer(f"http://{live.address}", ADMIN), rooms=2, clients=1, seconds=1)
    assert len(opened) == 1
    assert live.rooms == before


def test_the_load_test_says_that_trainings_learn_from_what_a_server_records(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["loadtest", "--help"])
    assert "trainings without --seats human learn from these" in " ".join(capsys.readouterr().out.split())


def test_the_load_test_says_in_a_sentence_why_no_room_is_opened(live: Live) -> None:
    target = RunningServer(f"http://{live.address}", ADMIN)
    with pytest.raises(LoadTestError, match=r"^/api/rooms answers 422: unknown agent 'scriptet'"):
        measure(target, rooms=1, clients=1, seconds=1, partner="scriptet")


def test_the_load_test_measures_one_node_and_not_whichever_a_proxy_asks() -> None:
    nodes = [{"name": name, "address": f"10.0.0.{at}:8001", "state": "serving"} for at, name in enumerate("ab", 1)]
    state = {"cluster": {"node": "a", "home": "k", "nodes": nodes}}
    proxy = RunningServer("http://game.example.org", ADMIN)
    loadtest._refuse_several_nodes(proxy, ["kaaa", "kbbb"], state)
    loadtest._refuse_several_nodes(proxy, ["kaaa", "mbbb"], {})
    with pytest.raises(LoadTestError, match=r"several nodes of a cluster.*--url with one of http://10\.0\.0\.1:8001, "):
        loadtest._refuse_several_nodes(proxy, ["kaaa", "mbbb"], state)
    with pytest.raises(LoadTestError, match="several nodes"):
        loadtest._refuse_several_nodes(proxy, ["maaa"], state)


@pytest.mark.slow
def test_the_load_test_starts_a_server_for_an_agent_of_ones_own(capsys: pytest.CaptureFixture[str]) -> None:
    command = "loadtest --rooms 1 --clients 1 --seconds 0.5 --json --partner tests.agents.support:Forward"
    assert main(command.split()) == 0
    assert json.loads(capsys.readouterr().out)["rooms"] == 1


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("--rooms 0", "--rooms: a whole number from 1 to 100,000 is possible, not 0"),
        ("--clients -1", "--clients: a whole number from 1 to 100,000 is possible, not -1"),
        ("--seconds nan", "--seconds: a number above 0 and up to 100,000 is possible, not nan"),
        ("--inputs 0", "--inputs: a number above 0 and up to 100,000 is possible, not 0"),
        ("--url rubbish", "--url: a server's address looks like http://127.0.0.1:8000, not 'rubbish'"),
        ("--url http://127.0.0.1:8000/play", "a server's address looks like"),
    ],
)
def test_the_load_test_refuses_what_it_cannot_measure(capsys: pytest.CaptureFixture[str], words: str, why: str) -> None:
    with pytest.raises(SystemExit):
        main(["loadtest", *words.split()])
    assert why in capsys.readouterr().err


def test_sigterm_leaves_no_server_behind_that_a_command_has_started() -> None:
    program = """
import os, signal
from movingout.server.commands.orderly_end import ended_by_sigterm
try:
    with ended_by_sigterm():
        os.kill(os.getpid(), signal.SIGTERM)
        signal.pause()
finally:
    print("the server is ended")
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (128 + signal.SIGTERM, "the server is ended\n")


@pytest.mark.slow
def test_a_server_ends_when_the_command_that_has_started_it_is_killed(tmp_path: Path) -> None:
    command = [*PROGRAM, "play", "--port", "0", "--data", str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdin is not None and server.stdout is not None
        assert next(line for line in server.stdout if "Admin token" in line)
        server.stdin.close()  # which is what a killed program leaves
        assert server.wait(60) == 0


def test_a_certificate_is_kept_covers_this_machine_and_its_key_is_private(tmp_path: Path) -> None:
    first = certificate_in(tmp_path / "tls", "127.0.0.1")
    content = first.certificate.read_bytes()
    assert certificate_in(tmp_path / "tls", "127.0.0.1").certificate.read_bytes() == content
    assert first.key.stat().st_mode & 0o077 == 0
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(first.certificate, first.key)
    assert {"localhost", "127.0.0.1"} <= set(host_names("127.0.0.1"))


def test_a_certificate_that_does_not_cover_a_new_address_is_made_anew(tmp_path: Path) -> None:
    first = certificate_in(tmp_path, "127.0.0.1").certificate.read_bytes()
    assert certificate_in(tmp_path, "10.1.2.3").certificate.read_bytes() != first
    (tmp_path / "certificate.pem").write_text("broken")
    assert b"BEGIN CERTIFICATE" in certificate_in(tmp_path, "10.1.2.3").certificate.read_bytes()
