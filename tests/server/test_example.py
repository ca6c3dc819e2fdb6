"""The example program delivers an item from a remote seat, and says why it cannot."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.server.live import Live

SECONDS_TO_START = 60  # of a program on a busy machine
EXAMPLE = Path(__file__).parents[2] / "examples" / "remote_agent.py"


def started(*words: str) -> subprocess.Popen[str]:
    return subprocess.Popen([sys.executable, str(EXAMPLE), *words], stderr=subprocess.PIPE, text=True)


@pytest.mark.slow
@pytest.mark.parametrize(("seats", "item"), [(("remote", "idle"), 0), (("idle", "remote"), 1)], ids=["blue", "red"])
def test_the_example_carries_its_item_home(live: Live, seats: tuple[str, str], item: int) -> None:
    room = live.open_room(*seats)
    watcher = live.person(room["room"], mode="watch")
    with started(f"http://{live.address}", room["room"]) as program:
        while not (watcher.bundles and watcher.bundles[-1].delivered[item]):
            watcher.hear(SECONDS_TO_START)
            assert len(watcher.bundles) < 200, "nothing delivered after twenty seconds"
        program.wait(SECONDS_TO_START)
        assert program.returncode == 0, program.stderr and program.stderr.read()


def test_the_example_says_why_it_cannot_play(live: Live) -> None:
    for words, sentence in (
        ((f"http://{live.address}", "nowhere"), "This room no longer exists"),
        (("http://127.0.0.1:9", "room"), "cannot connect to ws://127.0.0.1:9/ws/room"),
        ((), "python examples/remote_agent.py http"),
    ):
        with started(*words) as program:
            _, said = program.communicate(timeout=SECONDS_TO_START)
        assert program.returncode == 1 and sentence in said and "Traceback" not in said
