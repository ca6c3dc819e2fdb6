"""A folder of recordings that the tests of several commands read."""

from pathlib import Path

import pytest

from movingout.recordings import SeatInfo, finalise
from tests.recordings.support import STARTED_NS, begin, play, record

DAY_NS = 86_400 * 10**9


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three finished recordings and one interrupted journal."""
    folder = tmp_path_factory.mktemp("data")
    recordings = folder / "recordings"
    finalise(record(recordings, ticks=12, episode_id="first")[0])
    bass = (SeatInfo("human", "P-77", device="touch"), SeatInfo("agent", "bass@all"))
    later: dict[str, object] = {"map_name": "LeftRight", "seats": bass, "started_ns": STARTED_NS + DAY_NS, "study": {}}
    finalise(record(recordings, ticks=9, episode_id="second", outcome="left", **later)[0])
    finalise(record(recordings, ticks=3, episode_id="third", outcome="delivered")[0])
    writer, played = begin(recordings, episode_id="broken-off")
    play(writer, played, 4)
    writer.abandon()
    return folder
