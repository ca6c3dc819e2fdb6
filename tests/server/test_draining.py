"""Draining: the server ends when the rounds that have begun are over, and none is lost or repeated."""

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from movingout.recordings.verification import verify
from movingout.server import messages as m
from movingout.server.cli import main
from movingout.server.drain_signal import let_in
from tests.server.live import WAIT_S, Live, Person, serve, wait_until
from tests.server.processes.cluster import cluster


def play_until_it_ends(live: Live) -> tuple[str, Person]:
    """Two rounds are wanted and one is being played when the server is told to drain."""
    room = live.open_room("here", "idle", maps=("Simple", "HandOff"), limit_ticks=30)
    person = live.person(room["room"], tokens=room["tokens"][:1])
    person.say(type="ready", seat=0, ready=True)
    person.play(5)
    assert live.server is not None
    live.run(live.server.drain)
    refused = live.call("/api/rooms", {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]})
    assert (refused[0], refused[1]["error"]["values"]["refusal"]) == (503, "restarting")
    person.play_out()
    person.say(type="ready", seat=0, ready=True)
    code, told = person.end()
    assert code == m.CLOSE_SHUTDOWN
    assert "restart_soon" in {state.get("reason_code") for state in told}
    assert not any(state.get("phase") == "countdown" for state in told)
    return room["room"], person


@pytest.mark.slow
@pytest.mark.parametrize("processes", [1, 2])
def test_a_round_is_played_to_its_end_and_the_next_one_begins_after_the_restart(tmp_path: Path, processes: int) -> None:
    serving = serve(tmp_path) if processes == 1 else cluster(tmp_path, processes)
    with serving as live:
        room, person = play_until_it_ends(live)
    recorded = sorted((tmp_path / "recordings").glob("*.mcap*"))
    found = [verify(path) for path in recorded]
    assert [(one.ticks, one.identical) for one in found] == [(30, True)]
    with serve(tmp_path) as live:
        again = live.person(room, tokens=person.tokens)
        again.wait_for("result")  # of the round before
        again.say(type="ready", seat=0, ready=True)
        while again.results()[-1]["index"] == 0:
            again.answer_one()


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="what a process holds back is read there")
def test_a_server_that_is_told_to_drain_while_it_starts_does_so_once_it_is_there(tmp_path: Path) -> None:
    """The signal ended it: `systemctl reload` right after the start counted as a failure of the unit."""
    command = [sys.executable, "-m", "movingout.server.cli", "play", "--data", str(tmp_path), "--port", "0"]
    with subprocess.Popen([*command, "--processes", "1"], stdout=subprocess.PIPE, text=True) as process:
        wait_until(lambda: signal.SIGUSR1 in held_back(process.pid) or process.poll() is not None)
        process.send_signal(signal.SIGUSR1)
        printed, _ = process.communicate(timeout=WAIT_S)
    assert process.returncode == 0 and "Moving Out Live is ready." in printed


def held_back(pid: int) -> set[int]:
    """The signals that a process does not get for now."""
    mask = int(re.findall(r"SigBlk:\s+(\w+)", Path(f"/proc/{pid}/status").read_text())[0], 16)
    return {number for number in range(1, 65) if mask >> (number - 1) & 1}


@pytest.mark.parametrize(
    ("words", "held"), [("play --help", True), ("study serve --help", True), ("maps --help", False)]
)
def test_only_servers_hold_the_signal_back(words: str, held: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["movingout", *words.split()])
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [])
    try:
        with pytest.raises(SystemExit):
            main()
        assert (signal.SIGUSR1 in signal.pthread_sigmask(signal.SIG_BLOCK, [])) == held
        let_in()
        assert signal.SIGUSR1 not in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
