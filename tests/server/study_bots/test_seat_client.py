"""Policies and connections of simulated participants."""

import asyncio
import math
from pathlib import Path

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.recordings.storage.index import list_recordings
from movingout.server.frames import Bundle
from movingout.server.security.tokens import hash_token
from movingout.server.study_bots.policies import ScriptedPolicy, state_of
from movingout.server.study_bots.seat_client import SeatClient
from movingout.world import World
from tests.server.live import serve
from tests.server.support import make_bundle


def _bundle(world: World) -> Bundle:
    delivered = tuple(world.delivered().tolist())
    sent = make_bundle(tick=world.state().tick, delivered=delivered, poses=world.sub_poses())
    return Bundle.decode(sent.encode())


def test_the_state_is_read_from_the_wire_as_finely_as_the_wire_tells_it() -> None:
    world = World(load_map("HandOff"))
    for _ in range(5):
        world.step(np.array([[1.0, 0.5, 0.0], [0.4, -2.0, 0.0]]))
    seen, true = state_of(_bundle(world)), world.state()
    assert seen.tick == 5
    assert np.abs(seen.robot_poses - true.robot_poses)[:, :2].max() < 1e-4
    assert np.abs(seen.item_poses - true.item_poses)[:, :2].max() < 1e-4
    assert np.abs(seen.robot_velocities - true.robot_velocities)[:, :2].max() < 0.02


def test_velocities_do_not_jump_where_the_angle_wraps() -> None:
    poses = np.zeros((5, 3, 3))
    poses[-2, 0, 2], poses[-1, 0, 2] = math.pi - 0.01, -math.pi + 0.01
    seen = state_of(make_bundle(delivered=(False,), poses=poses))
    assert seen.robot_velocities[0] == pytest.approx([0.0, 0.0, 1.0])


@pytest.mark.slow
@pytest.mark.parametrize("device", ["keyboard", "gamepad"])
def test_a_scripted_person_plays_a_round_to_its_end_also_over_a_connection_that_breaks(
    tmp_path: Path, device: str
) -> None:
    with serve(tmp_path, tick_s=0.02) as live:
        room = live.open_room("here", "idle", maps=("Simple",), limit_ticks=150)
        live.host.registry.rooms[room["room"]].seats[0].key = hash_token("key")  # as in a study
        seen = 0

        def drops() -> bool:
            nonlocal seen
            seen += 1
            return seen == 20

        def client() -> SeatClient:
            return SeatClient(
                f"ws://{live.address}",
                room=room["room"],
                token="key",
                policy=ScriptedPolicy("A01", 1),
                device=device,
            )

        async def play() -> tuple[bool, str]:
            assert not await client().play(drops)
            second = client()
            return await second.play(lambda: False), second.outcome

        assert asyncio.run(play()) in ((True, "time"), (True, "delivered"))
        asyncio.run_coroutine_threadsafe(live.host.recording_service.settled(), live.loop).result(20)
    found, broken = list_recordings(tmp_path / "recordings")
    assert broken == []
    assert [(one.metrics["tcr"] or 0) > 0 for one in found] == [True]
