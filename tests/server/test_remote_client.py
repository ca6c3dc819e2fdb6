"""`movingout.remote.Client`: agents play from another process, slow ones too, and refusals are sentences."""

import asyncio
import json
import subprocess
import sys
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from msgspec import to_builtins
from websockets.asyncio.server import ServerConnection, serve

from movingout import remote, remote_seat
from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.catalogue import load_agent
from movingout.maps import load_map
from movingout.maps.json_format import map_to_json
from movingout.remote import Client, RemoteError
from movingout.server import messages as m
from movingout.server.frames import FRAME_FIELDS, Input
from movingout.world.metrics import METRICS
from movingout.world.ping import HelpPing
from tests.server.live import Live
from tests.server.program_room import REFUSAL, RESULT, program_room, room_state, round_with_pings
from tests.server.support import make_bundle


def test_importing_the_client_loads_no_numbers_and_no_world() -> None:
    code = "import sys, movingout.remote; print(sorted({'numpy', 'pymunk', 'movingout.world'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_the_client_writes_the_numbers_of_the_server() -> None:
    """It does not import them: a program that only plays would load the server."""
    assert (remote.SUBPROTOCOL, remote.BUNDLE, remote_seat.INPUT) == (m.SUBPROTOCOL, m.BUNDLE, m.INPUT)
    scales = (remote_seat.POSITION, remote_seat.ANGLE, remote_seat.LEVEL)
    assert scales == (m.POSITION_SCALE, m.ANGLE_SCALE, m.AXIS_SCALE)
    assert m.DEVICES[remote_seat.PROGRAM] == "program"


@pytest.mark.parametrize("heading", [3.1, -3.1, 1.0, 0.0, np.pi, -np.pi])
def test_a_heading_is_the_one_that_the_server_reads(heading: float) -> None:
    seat = remote_seat.RemoteSeat(0, to_builtins(FRAME_FIELDS))
    seat.play([[1.0, np.cos(heading), np.sin(heading), 0.0]])
    read = Input.decode(seat.next_input()).heading
    assert abs(np.remainder(read - heading + 1, 2 * np.pi) - 1) <= 0.51 / m.ANGLE_SCALE


def test_a_client_that_is_not_connected_says_so() -> None:
    client = Client("http://127.0.0.1:8000", "x")
    assert (client.map, client.limit_ticks) == (None, 0)
    with pytest.raises(RemoteError, match="async with Client"):
        client.act([[0.0, 1.0, 0.0, 0.0]])


@pytest.mark.parametrize("said", ["{", '{"type": "round"}', b""])
def test_a_message_that_cannot_be_read_ends_the_wait_of_a_program(said: str | bytes) -> None:
    """It ended the reader alone, and the program waited for ever."""

    async def speak(socket: ServerConnection) -> None:
        seats = [{"seat": 0, "token": "t"}]
        await socket.send(json.dumps({"type": "welcome", "seats": seats, "frames": {}}))
        await socket.send(said)
        await socket.wait_closed()

    async def played() -> None:
        async with serve(speak, "127.0.0.1", 0, subprotocols=["movingout.v1"]) as server:  # type: ignore[list-item]
            port = next(iter(server.sockets)).getsockname()[1]
            async with Client(f"http://127.0.0.1:{port}", "x") as client:
                async for _ in client.observations():
                    raise AssertionError("there is nothing to see")

    with pytest.raises(RemoteError, match="cannot read what the server says: "):
        asyncio.run(asyncio.wait_for(played(), 20))


async def series(*said: dict[str, Any]) -> int:
    """How many rounds a program counts that plays until the series is over."""
    rounds = 0
    async with program_room(*said) as address, Client(address, "x") as client:
        while not client.over:
            async for _ in client.observations():
                raise AssertionError("there is nothing to see")
            rounds += 1
    return rounds


def test_a_program_knows_after_the_last_result_that_the_series_is_over() -> None:
    """It asked for a further round when `room` came later than the result, and waited for ever."""
    said = room_state("playing"), RESULT, room_state("series_over")
    assert asyncio.run(asyncio.wait_for(series(*said), 5)) == 1


@pytest.mark.parametrize(
    ("said", "sentence"),
    [
        (room_state("series_over", "Red left the game."), "^Red left the game.$"),
        (room_state("series_over"), "^the series is over$"),
        (REFUSAL, "^too many changes; wait a second$"),
    ],
)
def test_a_program_does_not_wait_for_a_round_that_will_not_come(said: dict[str, Any], sentence: str) -> None:
    with pytest.raises(RemoteError, match=sentence):
        asyncio.run(asyncio.wait_for(series(said), 5))


def test_a_program_that_comes_back_into_a_running_round_need_not_be_ready() -> None:
    said = room_state("playing"), REFUSAL, RESULT, room_state("series_over")
    assert asyncio.run(asyncio.wait_for(series(*said), 5)) == 1


def test_observations_have_the_requests_for_help_that_players_see() -> None:
    """They had none, so that agents that help as partners of a room passed over people as remote programs."""

    async def played() -> dict[int, tuple[HelpPing, ...]]:
        async with program_room(*round_with_pings()) as address, Client(address, "x") as client:
            return {observation.tick: observation.pings async for observation in client.observations()}

    asked = (HelpPing(tick=3, seat=1, item=1, x=0.5, y=-0.5),)
    assert asyncio.run(asyncio.wait_for(played(), 5)) == {2: (), 3: asked, 22: asked, 23: ()}


class InChunks:
    """Stands still for three ticks and presses in the fourth."""

    def reset(self, episode: EpisodeInfo) -> None:
        self.asked: list[int] = []

    def act(self, observation: Observation) -> ActionChunk:
        self.asked.append(observation.tick)
        return np.array([[0.0, 1.0, 0.0, row == 3] for row in range(4)])


def test_an_agent_is_asked_again_when_the_rows_of_its_chunk_are_played() -> None:
    """It was asked at every state, so that no row but the first was ever played."""
    pressed: list[int] = []

    async def speak(socket: ServerConnection) -> None:
        seats = [{"seat": 0, "token": "t"}]
        await socket.send(json.dumps({"type": "welcome", "seats": seats, "frames": to_builtins(FRAME_FIELDS)}))
        the_map = map_to_json(load_map("Simple"))
        await socket.send(json.dumps({"type": "round", "map": the_map, "limit_ticks": 16, "epoch": 1}))
        await socket.recv()  # join
        await socket.recv()  # ready
        poses = np.zeros((5, 2 + len(load_map("Simple").items), 3))
        for tick in range(1, 17):
            await socket.send(make_bundle(epoch=1, tick=tick, poses=poses).encode())
            pressed.append(Input.decode(await socket.recv()).grabs)  # type: ignore[arg-type]
        await socket.send(json.dumps({"type": "result", "outcome": "time", "ticks": 16, "recording": ""}))
        await socket.send(json.dumps(room_state("series_over")))
        await socket.wait_closed()

    async def played(agent: InChunks) -> None:
        async with serve(speak, "127.0.0.1", 0, subprotocols=["movingout.v1"]) as server:  # type: ignore[list-item]
            port = next(iter(server.sockets)).getsockname()[1]
            async with Client(f"http://127.0.0.1:{port}", "x") as client:
                await client.play(agent)

    agent = InChunks()
    asyncio.run(asyncio.wait_for(played(agent), 20))
    assert len(agent.asked) >= 2 and all(later - earlier >= 4 for earlier, later in pairwise(agent.asked))
    assert max(pressed) >= 2


@pytest.mark.slow
def test_an_agent_plays_a_round_from_outside_and_learns_how_it_ended(live: Live) -> None:
    room = live.open_room("idle", "remote", limit_ticks=60)

    async def played() -> None:
        async with Client(f"http://{live.address}", room["room"], name="mine") as client:
            assert client.seat == 1
            result = await client.play(load_agent("scripted"))
        assert (result.outcome, result.ticks) == ("time", 60)
        assert set(result.metrics) == {metric.key for metric in METRICS}

    asyncio.run(asyncio.wait_for(played(), 40))


@pytest.mark.slow
def test_a_chunk_is_played_on_while_a_slow_program_thinks_and_states_are_the_newest(live: Live) -> None:
    room = live.open_room("idle", "remote", limit_ticks=40)

    async def played() -> tuple[list[int], list[float]]:
        ticks, ways = [], []
        async with Client(f"ws://{live.address}/ws", room["room"]) as client:
            async for observation in client.observations():
                pose = observation.state.robot_poses[client.seat]
                ticks.append(observation.state.tick)
                ways.append(float(pose[1]))
                assert len(observation.encode("map-v1")) == 169
                client.act(np.tile([0.5, np.cos(pose[2]), np.sin(pose[2]), 0.0], (4, 1)))
                await asyncio.sleep(0.9)
        return ticks, ways

    ticks, ways = asyncio.run(asyncio.wait_for(played(), 40))
    assert 3 <= len(ticks) <= 6 and all(later - earlier >= 6 for earlier, later in pairwise(ticks))
    assert max(ways) - min(ways) > 0.05


def test_only_an_agent_itself_can_play(live: Live) -> None:
    async def played(agent: Any) -> None:
        async with Client(f"http://{live.address}", live.open_room("idle", "remote")["room"]) as client:
            await client.play(agent)

    for wrong in ("scripted", object()):
        with pytest.raises(RemoteError, match=r"an object with reset\(\) and act\(\), as of load_agent"):
            asyncio.run(asyncio.wait_for(played(wrong), 20))


def test_refusals_are_sentences(live: Live) -> None:
    async def entered(client: Client) -> None:
        async with client:
            pass

    room = live.open_room("idle", "idle")["room"]
    for client, sentence in (
        (Client(f"http://{live.address}", "nowhere"), "room"),
        (Client(f"http://{live.address}", room), "This room is full"),
        (Client("http://127.0.0.1:9", "x"), "cannot connect to ws://127.0.0.1:9/ws"),
    ):
        with pytest.raises(RemoteError, match=sentence):
            asyncio.run(entered(client))
    with pytest.raises(RemoteError, match="write http://127"):
        Client("127.0.0.1:8000", "x")
