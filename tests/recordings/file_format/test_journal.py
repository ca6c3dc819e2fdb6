"""The journal against everything that can happen to its bytes."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from movingout.recordings import read_episode, recover, verify
from movingout.recordings.file_format.journal import scan
from tests.recordings.support import assert_holds, begin, play, record
from tests.support import ROOT


def group_ends(folder: Path, ticks: int) -> tuple[bytes, list[int]]:
    """A journal's bytes and where each of its groups ends, head first."""
    writer, played = begin(folder)
    ends = [writer.path.stat().st_size]
    for _ in range(ticks):
        play(writer, played, 1)
        ends.append(writer.path.stat().st_size)
    writer.abandon()
    return writer.path.read_bytes(), ends


def test_cut_off_anywhere_it_keeps_every_whole_tick(tmp_path: Path) -> None:
    data, ends = group_ends(tmp_path, ticks=4)
    for length in [*range(0, len(data), 3), *(end + step for end in ends for step in (-1, 0, 1))]:
        found = scan(data[:length])
        kept = max((end for end in ends if end <= length), default=0)
        assert (found.end, found.torn, found.damage) == (kept, min(length, len(data)) - kept, ""), length


def test_a_flipped_bit_is_found_wherever_it_is(tmp_path: Path) -> None:
    data, ends = group_ends(tmp_path, ticks=4)
    choice = random.Random(1)
    for position in [*range(0, len(data), 5), *range(ends[-2], len(data))]:
        flipped = bytearray(data)
        flipped[position] ^= 1 << choice.randrange(8)
        found = scan(bytes(flipped))
        kept = max((end for end in ends if end <= position), default=0)
        assert found.end == kept, f"byte {position}: nothing after the change may be trusted"
        assert found.damage or found.torn, f"byte {position}: the loss must be reported"


def test_a_flip_before_the_last_tick_is_called_damage_not_a_torn_end(tmp_path: Path) -> None:
    data, ends = group_ends(tmp_path, ticks=4)
    for position in range(ends[1], ends[2], 3):
        flipped = bytearray(data)
        flipped[position] ^= 0x10
        assert "nothing after tick 1 can be trusted" in scan(bytes(flipped)).damage, position


def test_a_tail_of_zeros_after_a_power_failure_is_cut_off(tmp_path: Path) -> None:
    data, ends = group_ends(tmp_path, ticks=4)
    found = scan(data + bytes(4096))
    assert (found.end, found.torn, found.damage) == (ends[-1], 4096, "")


def test_bytes_that_are_no_journal_hold_nothing() -> None:
    for data in (b"", b"\x89MCAP0\r\n", b"garbage" * 100, os.urandom(5000)):
        assert scan(data).end == 0


_WRITE_FOREVER = """
import sys
from pathlib import Path
from tests.recordings.support import begin, play_tick
writer, played = begin(Path(sys.argv[1]))
while True:
    play_tick(writer, played)
    print(played.world.tick, flush=True)
"""


def kill_while_it_writes(folder: Path, after_ticks: int, delay_s: float = 0.0) -> int:
    """SIGKILL a writing process; the last tick that it said was written."""
    command = [sys.executable, "-c", _WRITE_FOREVER, str(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
        assert process.stdout is not None
        while (told := int(process.stdout.readline())) < after_ticks:
            pass
        time.sleep(delay_s)
        process.send_signal(signal.SIGKILL)
        rest = process.stdout.read().splitlines(keepends=True)
    return max(told, *(int(line) for line in rest if line.endswith("\n")), 0)


def assert_nothing_is_lost(folder: Path, told: int) -> None:
    (entry,) = recover(folder)
    assert entry.ticks >= told
    assert entry.recording is not None
    episode = read_episode(entry.recording)
    assert (episode.outcome, episode.complete) == ("interrupted", False)
    assert verify(entry.recording).identical


@pytest.mark.parametrize("after_ticks", [1, 23, 57])
def test_a_killed_writer_loses_nothing_but_the_tick_in_flight(tmp_path: Path, after_ticks: int) -> None:
    assert_nothing_is_lost(tmp_path, kill_while_it_writes(tmp_path, after_ticks))


@pytest.mark.slow
def test_killed_at_random_moments_again_and_again(tmp_path: Path) -> None:
    choice = random.Random(3)
    for attempt in range(10):
        folder = tmp_path / str(attempt)
        assert_nothing_is_lost(folder, kill_while_it_writes(folder, 1, choice.uniform(0.0, 0.3)))


def test_recovering_says_what_became_of_each_journal(tmp_path: Path) -> None:
    _, whole = record(tmp_path, ticks=3, episode_id="ended")
    running, _ = begin(tmp_path, episode_id="running")
    writer, played = begin(tmp_path, episode_id="cut")
    play(writer, played, 5)
    writer.abandon()
    os.truncate(writer.path, writer.path.stat().st_size - 10)
    (tmp_path / "torn.mcap.journal").write_bytes(b"\x89MCAP0\r\n\x01")
    notes = {entry.journal.name.split(".")[0]: (entry.ticks, entry.note) for entry in recover(tmp_path)}
    running.abandon()
    assert notes["ended"] == (3, "whole")
    assert notes["cut"] == (4, "interrupted after tick 4")
    assert notes["running"] == (0, "being written by another process; left alone")
    assert notes["torn"][1].startswith("nothing readable")
    assert_holds(read_episode(tmp_path / "ended.mcap"), whole)
    assert_holds(read_episode(tmp_path / "cut.mcap"), played, ticks=4)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "cut.mcap",
        "ended.mcap",
        "running.mcap.journal",
        "torn.mcap.journal.unreadable",
    ]
    assert [entry.journal.name for entry in recover(tmp_path)] == ["running.mcap.journal"]


def test_a_damaged_journal_is_kept_beside_what_could_be_saved(tmp_path: Path) -> None:
    data, ends = group_ends(tmp_path, ticks=6)
    flipped = bytearray(data)
    flipped[ends[3] + 50] ^= 4
    journal = tmp_path / "episode.mcap.journal"
    journal.write_bytes(flipped)
    (entry,) = recover(tmp_path)
    assert (entry.ticks, entry.note) == (
        3,
        "bytes changed after they were written: nothing after tick 3 can be trusted",
    )
    episode = read_episode(tmp_path / "episode.mcap")
    assert (len(episode.ticks), episode.complete, episode.damage) == (3, False, entry.note)
    assert (tmp_path / "episode.mcap.journal.damaged").read_bytes() == bytes(flipped)


def test_recovering_after_a_crash_between_renaming_and_removing(tmp_path: Path) -> None:
    journal, played = record(tmp_path, ticks=3)
    kept = journal.read_bytes()
    recover(tmp_path)
    journal.write_bytes(kept)
    (entry,) = recover(tmp_path)
    assert (entry.note, journal.exists()) == ("whole", False)
    assert_holds(read_episode(tmp_path / "episode.mcap"), played)


def test_a_journal_never_replaces_another_episode(tmp_path: Path) -> None:
    journal, _ = record(tmp_path, ticks=3)
    recover(tmp_path)
    record(tmp_path / "other", ticks=4, map_name="LeftRight")
    (tmp_path / "other" / "episode.mcap.journal").replace(journal)
    finished = (tmp_path / "episode.mcap").read_bytes()
    (entry,) = recover(tmp_path)  # which raises for none: the journals after it are finished, too
    assert entry.failed and "is another episode; move one of the two away" in entry.note
    assert (tmp_path / "episode.mcap").read_bytes() == finished
    assert journal.exists()
