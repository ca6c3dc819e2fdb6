"""What one seat did in a recording, and how it is named wherever it is replayed."""

import shutil
from pathlib import Path

from movingout.recordings import finalise
from movingout.recordings.recorded_seat import ghost_name, read_recorded_seat
from tests.recordings.support import record


def test_a_ghost_is_named_by_its_episode_whatever_the_file_is_called(tmp_path: Path) -> None:
    """A copy made somebody else of who played then, and the two were not seen to be one person."""
    journal, _ = record(tmp_path, ticks=3, episode_id="then")
    assert ghost_name(f"ghost:{journal}#blue") == "ghost:then#blue"
    copy = shutil.copy(finalise(journal), tmp_path / "best.mcap")
    assert ghost_name(f"ghost:{copy}#red") == "ghost:then#red"
    assert read_recorded_seat(f"{copy}#red").episode_id == "then"
    assert ghost_name(f"ghost:{tmp_path}/gone.mcap#red") == "ghost:gone#red"
