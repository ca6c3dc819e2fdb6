"""A round as one picture or animation to send: small, without names, faster where it was long."""

import io
from pathlib import Path

import pytest
from PIL import Image, ImageSequence

from movingout.recordings import RecordingError, SeatInfo, finalise
from movingout.recordings.exports import gif
from movingout.recordings.exports.share import LONGEST_S, SHARE_KINDS, share_bytes
from tests.recordings.support import record


def recorded(folder: Path, ticks: int, name: str = "P-9") -> Path:
    people = SeatInfo("human", name, device="keyboard"), SeatInfo("human", f"{name}x", device="touch")
    journal, _ = record(folder, ticks=ticks, episode_id=f"{name}-{ticks}", map_name="LeftRight", seats=people)
    return finalise(journal)


def frames(content: bytes) -> int:
    return sum(1 for _ in ImageSequence.Iterator(Image.open(io.BytesIO(content))))


def test_nobody_is_named_on_it(tmp_path: Path) -> None:
    one, other = recorded(tmp_path / "a", 20, "Anna"), recorded(tmp_path / "b", 20, "Bert")
    for kind in SHARE_KINDS:
        assert share_bytes(one, kind) == share_bytes(other, kind)


def test_its_caption_is_in_the_language_that_is_asked_for(tmp_path: Path) -> None:
    one = recorded(tmp_path, 20)
    english, german, other = (share_bytes(one, "png", language) for language in ("en", "de", "xx"))
    assert english != german and english == other


def test_a_long_round_runs_faster_and_stays_small(tmp_path: Path) -> None:
    content = share_bytes(recorded(tmp_path, 1200), "gif")
    assert 60 < frames(content) <= LONGEST_S * gif.FPS + 1  # equal pictures in a row are one
    assert len(content) < 1_000_000


def test_a_file_that_cannot_be_read_is_said(tmp_path: Path) -> None:
    broken = tmp_path / "x.mcap"
    broken.write_bytes(b"nothing")
    with pytest.raises(RecordingError):
        share_bytes(broken, "png")
