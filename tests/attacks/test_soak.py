"""Players who come and go at random while room processes are killed: nothing is lost, and memory does not grow.

`python -m bench soak --minutes 60` is the long one.
"""

import asyncio
from pathlib import Path
from random import Random

import pytest

from tests.attacks.soak import Soak, Tally, collecting_often, faults_of, server_at, wait_for_recordings

PLAYERS, SECONDS = 30, 180.0  # each player has a room
KILL_EVERY_S, KILLS_FOR_S = 12.0, 40.0
WARM_UP_S = 100.0
MOST_MB_PER_MINUTE = 3.0
"""The aim, 0.1, is too little for three minutes: it was 0.5 when collections waited for objects, and 8 when they waited
for memory, which stays where garbage once took it. Without any collection it was 18.6."""


def test_the_slope_of_memory_is_that_of_its_level_not_of_its_peaks() -> None:
    at = [float(second) for second in range(120)]
    tally = Tally(at_s=at, rss_mb=[100.0 + second / 6 + (50.0 if second % 9 == 0 else 0.0) for second in at])
    assert tally.mb_per_minute(0.0) == pytest.approx(10.0, abs=0.5)
    assert Tally(at_s=at, rss_mb=[100.0 if one > 40 else one for one in at]).mb_per_minute(41.0) == 0.0


@pytest.mark.slow
def test_no_seat_and_no_recording_is_lost_and_memory_is_level(tmp_path: Path) -> None:
    data = tmp_path / "data"
    data.mkdir()
    with server_at(data, 2, collecting_often(tmp_path / "often")) as (base, token, process):
        tally = asyncio.run(Soak(base, token, process, Random(1)).run(PLAYERS, SECONDS, KILL_EVERY_S, KILLS_FOR_S))
        wait_for_recordings(data / "recordings")
    assert tally.lost == []
    assert faults_of(data / "recordings") == []
    assert min(tally.rounds, tally.drops, tally.kills, tally.floods) > 0, tally
    files, third = tally.open_files, len(tally.open_files) // 3
    assert max(files[-third:]) <= max(files[:-third]) + 3 * PLAYERS, "open files are level"
    slope = tally.mb_per_minute(WARM_UP_S)
    assert slope < MOST_MB_PER_MINUTE, f"{tally.rounds} rounds, memory {tally.rss_mb[-1]:.0f} MB, {slope:+.2f} a minute"
