"""Draining: the server ends when the rounds that have begun are over, and none is lost or repeated."""

from pathlib import Path

import pytest

from movingout.recordings.verification import verify
from movingout.server import messages as m
from tests.server.live import Live, Person, serve
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
