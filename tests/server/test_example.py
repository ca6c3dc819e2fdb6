"""The example program of docs/protocol.md delivers an item from a remote seat."""

import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from movingout.server import messages as m
from movingout.server.frames import FRAME_FIELDS, Input
from tests.server.live import Live
from tests.server.support import make_bundle

EXAMPLE = Path(__file__).parents[2] / "examples" / "remote_agent.py"
FRAMES = msgspec.to_builtins(FRAME_FIELDS)  # as the welcome has them


def _example() -> Any:
    return runpy.run_path(str(EXAMPLE))


def test_the_example_reads_the_bundles_that_the_server_declares() -> None:
    poses = np.arange(5 * 4 * 3).reshape(5, 4, 3) / 100
    tick, held, last = _example()["newest"](FRAMES, make_bundle(tick=17, held=(1, -1), poses=poses).encode())
    assert (tick, held) == (17, (1, -1))
    assert np.array(last) == pytest.approx(poses[-1], abs=1e-3)


def test_the_example_writes_the_inputs_that_the_server_declares() -> None:
    sent = Input.decode(_example()["steering"](FRAMES, 12, -0.5, 1.25, seat=1, seq=7, grabs=2))
    assert (sent.seat, sent.seq, sent.ack_tick, sent.seen_tick, sent.grabs) == (1, 7, 12, 12, 2)
    assert m.DEVICES[sent.device] == "program"
    assert (sent.move, sent.heading) == pytest.approx((-0.5, 1.25), abs=1e-3)


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
    assert len(lines) <= 70
    imported = {line.split()[1].split(".")[0] for line in lines if line.startswith(("import ", "from "))}
    assert imported - set(sys.stdlib_module_names) == {"websockets"}
