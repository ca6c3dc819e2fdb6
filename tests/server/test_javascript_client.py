"""The client for JavaScript plays a round from Node, and says a refusal in the server's words."""

import asyncio
import json
import math
import subprocess
from pathlib import Path
from typing import Any

import pytest

from movingout.server.frames import Input
from movingout.server.messages import ANGLE_SCALE
from tests.server.live import Live
from tests.server.program_room import REFUSAL, RESULT, program_room, room_state, round_with_pings
from tests.support import ROOT

CLIENT = Path(__file__).parents[2] / "examples" / "javascript-client" / "client.js"
PLAY = """
const { Client } = await import(process.argv[1]);
try {
  const client = await Client.connect(process.argv[2], process.argv[3], { name: "node" });
  const ways = [], first = {};
  for await (const state of client.states()) {
    const robot = state.robots[client.seat];
    first.items ??= state.items.length;
    ways.push(robot.y);
    const [cos, sin] = [Math.cos(robot.angle), Math.sin(robot.angle)];
    client.act([[0.5, cos, sin, 0], [0.5, cos, sin, 0]]);
  }
  const { outcome, ticks, metrics } = client.result;
  const way = Math.max(...ways) - Math.min(...ways);
  const items = [first.items, client.map.items.length];
  console.log(JSON.stringify({ outcome, ticks, seat: client.seat, states: ways.length, way, items, tcr: metrics.tcr }));
  client.close();
} catch (error) {
  console.log(JSON.stringify({ name: error.constructor.name, message: error.message }));
}
"""


def node(*words: str) -> dict[str, object]:
    command = ["node", "--experimental-websocket", "--input-type=module", "--eval", PLAY, "--", str(CLIENT), *words]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    told: dict[str, object] = json.loads(ran.stdout)
    return told


DECLARE = "--allowJs --declaration --emitDeclarationOnly --target es2023 --module nodenext --lib es2023,dom"
TRY = """
const { Client } = await import(process.argv[1]);
const client = new Client({ readyState: 0 });
for (const rows of ["ahead", undefined, [], [[1, 1, 0]], [[NaN, 1, 0, 0]], [null], [1, 1, 0, 0]])
  try { client.act(rows); } catch (error) { console.log(String(error)); }
try { await Client.connect("127.0.0.1:8000", "x"); } catch (error) { console.log(String(error)); }
"""


def test_what_is_no_chunk_and_no_address_is_said() -> None:
    command = ["node", "--experimental-websocket", "--input-type=module", "--eval", TRY, "--", str(CLIENT)]
    told = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout.splitlines()
    chunk = "RemoteError: a chunk is rows of four numbers: distance, cos and sin of the heading, grasp"
    assert told == [chunk] * 7 + [
        "RemoteError: '127.0.0.1:8000' is no address of a server; write http://127.0.0.1:8000"
    ]


def test_the_declarations_for_typescript_are_those_of_the_module(tmp_path: Path) -> None:
    command = [str(ROOT / "node_modules/.bin/tsc"), *DECLARE.split(), "--outDir", str(tmp_path), str(CLIENT)]
    subprocess.run(command, check=True, timeout=120, cwd=CLIENT.parent)
    assert (tmp_path / "client.d.ts").read_text() == CLIENT.with_suffix(".d.ts").read_text()


SERIES = """
const { Client } = await import(process.argv[1]);
const client = await Client.connect(process.argv[2], "x");
let rounds = 0;
try {
  for (; !client.over; rounds++) for await (const state of client.states()) console.log("there is nothing to see");
  console.log(`${rounds} rounds`);
} catch (error) {
  console.log(String(error));
}
client.close();
"""


TURN = """
for (const heading of [3.1, Math.PI, -Math.PI]) client.act([[0, Math.cos(heading), Math.sin(heading), 0]]);
client.close();
"""


async def run_node(script: str, address: str) -> str:
    """What a script writes that plays in a room."""
    command = ["node", "--experimental-websocket", "--input-type=module", "--eval", script, "--", str(CLIENT)]
    ran = await asyncio.create_subprocess_exec(*command, address, stdout=subprocess.PIPE)
    try:
        return (await asyncio.wait_for(ran.communicate(), 10))[0].decode()
    finally:
        if ran.returncode is None:
            ran.kill()
            await ran.wait()


def test_a_heading_is_the_one_that_the_server_reads() -> None:
    heard: list[str | bytes] = []

    async def played() -> None:
        async with program_room(room_state("series_over"), heard=heard) as address:
            await run_node(SERIES.replace("client.close();", TURN), address)

    asyncio.run(played())
    read = [Input.decode(frame).heading for frame in heard if isinstance(frame, bytes)]
    assert read == pytest.approx([3.1, -math.pi, -math.pi], abs=0.51 / ANGLE_SCALE)


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ([room_state("playing"), RESULT, room_state("series_over")], "1 rounds"),
        ([room_state("series_over", "Red left the game.")], "RemoteError: Red left the game."),
        ([room_state("series_over")], "RemoteError: the series is over"),
        ([REFUSAL], "RemoteError: too many changes; wait a second"),
        ([room_state("playing"), REFUSAL, RESULT, room_state("series_over")], "1 rounds"),
    ],
)
def test_a_program_does_not_wait_for_a_round_that_will_not_come(said: list[dict[str, Any]], told: str) -> None:
    async def played() -> str:
        async with program_room(*said) as address:
            return await run_node(SERIES, address)

    assert asyncio.run(played()) == f"{told}\n"


def test_states_have_the_requests_for_help_that_players_see() -> None:
    shown = "console.log(JSON.stringify([state.tick, state.pings]))"

    async def played() -> str:
        async with program_room(*round_with_pings()) as address:
            return await run_node(SERIES.replace('console.log("there is nothing to see")', shown), address)

    *states, last = asyncio.run(played()).splitlines()
    asked = [{"tick": 3, "seat": 1, "item": 1, "x": 0.5, "y": -0.5}]
    assert [json.loads(line) for line in states] == [[2, []], [3, asked], [22, asked], [23, []]]
    assert last == "1 rounds"


@pytest.mark.slow
def test_a_round_is_played_from_node(live: Live) -> None:
    room = live.open_room("idle", "remote", limit_ticks=30)["room"]
    told = node(f"http://{live.address}", room)
    assert (told["outcome"], told["ticks"], told["seat"], told["tcr"]) == ("time", 30, 1, 0)
    assert isinstance(told["items"], list) and told["items"][0] == told["items"][1] > 0
    assert isinstance(told["states"], int) and told["states"] > 10
    assert isinstance(told["way"], float) and told["way"] > 0.05


def test_refusals_are_the_servers_sentences(live: Live) -> None:
    full = live.open_room("idle", "idle")["room"]
    assert "This room is full" in str(node(f"http://{live.address}", full)["message"])
    assert node("http://127.0.0.1:9", "x") == {
        "name": "RemoteError",
        "message": "cannot connect to ws://127.0.0.1:9/ws/x",
    }
