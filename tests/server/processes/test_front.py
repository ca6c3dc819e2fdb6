"""Which process a server with several gives a room to."""

import asyncio
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from movingout.server.monitoring.overload import ProcessHealth
from movingout.server.processes.channel import ProcessGone
from movingout.server.processes.front import Front
from movingout.server.rooms.services import RoomConfig
from movingout.server.settings import Settings

BROKEN = "saving: Input/output error"


def process(name: str, rooms: int, unwritable: str) -> Any:
    """A process that opens rooms under its name."""

    async def call(work: Callable[..., Any], *args: Any) -> str:
        return name

    health = ProcessHealth(agents=True, unwritable=unwritable)
    return SimpleNamespace(
        call=call, health=health, is_ready=True, rooms=set(range(rooms)), faults=lambda: iter(()), index=0
    )


@pytest.fixture
def front(tmp_path: Path) -> Iterator[Front]:
    front = Front(Settings(data=tmp_path), processes=1, keep=0)
    front.links = [process("a", 0, BROKEN), process("b", 5, "")]
    yield front


def test_rounds_of_a_study_begin_in_the_processes_that_can_record_them(front: Front) -> None:
    of_a_study, other = RoomConfig(maps=("Simple",), study={"id": "s"}), RoomConfig(maps=("Simple",))
    assert front.health().unwritable == ""
    assert asyncio.run(front.open_room(of_a_study, [])) == "b"
    assert asyncio.run(front.open_room(other, [])) == "a"
    front.links = [process("a", 0, BROKEN)]
    assert front.health().unwritable == BROKEN
    with pytest.raises(ProcessGone):
        asyncio.run(front.open_room(of_a_study, []))
