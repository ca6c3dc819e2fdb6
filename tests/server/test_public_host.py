"""Disks that are full or broken, and maps that are made ahead of their rounds."""

import asyncio
import errno
import gc
import os
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from movingout.maps import MapSpec
from movingout.server.host import Host
from movingout.server.own_maps.workers import Busy
from movingout.server.rooms.services import RoomConfig
from movingout.server.settings import Settings


@pytest.mark.parametrize("fuller", ["data", "recordings"])
def test_recordings_on_a_disk_of_their_own_that_is_full_let_no_room_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fuller: str
) -> None:
    host = Host(Settings(data=tmp_path))
    host.settings.recordings.mkdir()
    full = getattr(host.settings, fuller)
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=8e3 if folder == full else 5e10))
    assert host.disk_free() == 8e3 and host.refusal().code == "disk_full"


def test_a_broken_disk_of_recordings_lets_no_room_open_and_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    host = Host(Settings(data=tmp_path))
    host.settings.recordings.mkdir()
    stat = Path.stat

    def broken(path: Path, **options: bool) -> os.stat_result:
        if path == host.settings.recordings:
            raise OSError(errno.EIO, "input/output error", str(path))
        return stat(path, **options)

    monkeypatch.setattr(Path, "stat", broken)
    monkeypatch.setattr(Path, "exists", lambda path: False)  # as Python 3.14 answers about a broken disk
    assert host.disk_free() == 0 and host.refusal().code == "disk_full"
    assert host.refusal().message in host.why_not_ready() and host.cannot_record().code == "disk_full"


def test_maps_that_are_made_ahead_may_find_the_process_busy_which_is_logged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made: list[int] = []
    unheard: list[Any] = []

    async def first_alone(designed: MapSpec, seed: int, split: str, address: str) -> MapSpec:
        if made:
            raise Busy("too many maps")
        made.append(seed)
        return designed

    async def prepare() -> None:
        asyncio.get_running_loop().set_exception_handler(lambda _, context: unheard.append(context))
        host = Host(Settings(data=tmp_path))
        host.map_workers = SimpleNamespace(variant=first_alone)  # type: ignore[assignment]
        await host.prepare_maps(RoomConfig(maps=("HandOff", "Simple"), challenge2_seed=5))
        for _ in range(3):
            await asyncio.sleep(0)
        gc.collect()

    asyncio.run(prepare())
    assert (made, unheard) == ([5], [])
    assert "not varied ahead: too many maps" in caplog.text
