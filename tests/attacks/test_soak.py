"""Players who come and go at random while room processes are killed: no seat, tick or recording is lost.

`python -m bench soak --minutes 60` is the long one.
"""

import asyncio
from pathlib import Path
from random import Random

import pytest

from tests.attacks.soak import Soak, faults_of, server_at

PLAYERS, SECONDS, KILL_EVERY_S = 6, 30.0, 9.0


@pytest.mark.slow
def test_no_seat_and_no_recording_is_lost(tmp_path: Path) -> None:
    data = tmp_path / "data"
    data.mkdir()
    with server_at(data, processes=2) as (base, token, process):
        tally = asyncio.run(Soak(base, token, process, Random(1)).run(PLAYERS, SECONDS, KILL_EVERY_S))
    assert tally.lost == []
    assert faults_of(data / "recordings") == []
    assert min(tally.rounds, tally.drops, tally.kills, tally.floods) > 0, tally
    files, third = tally.open_files, len(tally.open_files) // 3
    assert max(files[-third:]) <= max(files[:-third]) + 3 * PLAYERS, "open files are level"
