"""The example program of docs/protocol.md delivers an item from a remote seat."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.server.live import Live

EXAMPLE = Path(__file__).parents[2] / "examples" / "remote_agent.py"


@pytest.mark.parametrize(("seats", "item"), [(("remote", "idle"), 0), (("idle", "remote"), 1)], ids=["blue", "red"])
def test_the_example_carries_its_item_home(live: Live, seats: tuple[str, str], item: int) -> None:
    room = live.open_room(*seats)
    watcher = live.person(room["room"], mode="watch")
    command = [sys.executable, str(EXAMPLE), f"ws://{live.address}/ws", room["room"]]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as program:
        watcher.wait_for("room", phase="playing")
        while not (watcher.bundles and watcher.bundles[-1].delivered[item]):
            watcher.hear()
            assert len(watcher.bundles) < 200, "nothing delivered after twenty seconds"
        program.wait(20)
        assert program.returncode == 0, program.stderr and program.stderr.read()


def test_the_example_is_short_and_needs_websockets_alone() -> None:
    lines = EXAMPLE.read_text().splitlines()
    assert len(lines) <= 60
    imported = {line.split()[1].split(".")[0] for line in lines if line.startswith(("import ", "from "))}
    assert imported - set(sys.stdlib_module_names) == {"websockets"}
