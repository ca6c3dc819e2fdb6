"""Rounds that a server goes on with: whoever finishes what was left behind does not end them."""

import json
import os
from pathlib import Path

import pytest

from movingout.recordings.storage.finished import recover
from movingout.server.cli import main
from tests.recordings.support import begin, play, record


def room(data: Path, episode: str, study: str = "", folder: str = "") -> None:
    place = data / "rooms" / folder
    place.mkdir(parents=True, exist_ok=True)
    config = {"maps": ["Simple"], "study": {"study": study} if study else {}}
    (place / f"{episode}-room.json").write_text(json.dumps({"id": "x", "episode": episode, "config": config}))


def left(data: Path) -> Path:
    """A data folder with journals of a round of a study, of one at a node, of a game, and of a game that is over."""
    for name in ("one", "two", "three", "over"):
        record(data / "recordings", ticks=3, episode_id=name)
    room(data, "one", "morning")
    room(data, "two", folder="k.7")
    room(data, "three")
    (data / "rooms" / "damaged.json").write_text("{")
    os.mkfifo(data / "rooms" / "pipe.json")
    return data


def names(data: Path) -> list[str]:
    return sorted(path.name.removesuffix(".journal") for path in (data / "recordings").glob("*.journal"))


def test_journals_of_rounds_that_go_on_stay_and_it_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = left(tmp_path)
    assert main(["recordings", "recover", "--data", str(data)]) == 0
    kept = "left alone, because its round goes on when {} again; --all ends it"
    assert capsys.readouterr().out.splitlines() == [
        f"one.mcap.journal: 0 ticks, {kept.format('the study morning is served')}",
        "over.mcap.journal -> over.mcap: 3 ticks, whole",
        f"three.mcap.journal: 0 ticks, {kept.format('the server is started')}",
        f"two.mcap.journal: 0 ticks, {kept.format('the server is started')}",
    ]
    assert names(data) == ["one.mcap", "three.mcap", "two.mcap"]
    assert main(["recordings", "recover", str(data / "recordings" / "three.mcap.journal")]) == 0, "named by itself"
    assert main(["recordings", "recover", "--data", str(data), "--all"]) == 0
    assert names(data) == []


@pytest.mark.parametrize("place", [".", "recordings", "data/recordings", "elsewhere", "link"])
def test_they_are_found_from_wherever_the_folder_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    data = left(tmp_path / "data")
    if place in ("elsewhere", "link"):  # recordings on a disk of their own; a link to the folder
        real, link = (
            (tmp_path / "disk", data / "recordings")
            if place == "elsewhere"
            else (data / "recordings", tmp_path / "link")
        )
        if place == "elsewhere":
            (data / "recordings").rename(real)
        link.symlink_to(real)
    monkeypatch.chdir({".": data / "recordings", "recordings": data}.get(place, tmp_path))
    recover(Path("data/recordings" if place == "elsewhere" else place))
    assert names(data) == ["one.mcap", "three.mcap", "two.mcap"]


def test_one_that_is_being_written_is_said_to_be(tmp_path: Path) -> None:
    writer, played = begin(tmp_path / "recordings", episode_id="one")
    play(writer, played, 3)
    room(tmp_path, "one")
    assert [one.note for one in recover(tmp_path)] == ["being written by another process; left alone"]
    writer.abandon()
