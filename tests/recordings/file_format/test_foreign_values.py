"""Recordings that another program wrote: whole, with right checksums, and with values that no room records."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.recordings import Event, RecordingError, finalise, read_episode
from movingout.recordings.file_format import payloads
from movingout.recordings.file_format.metadata import EPISODE, RECORDING, RESULT, header_metadata, header_of
from movingout.recordings.file_format.payloads import read_event, read_input
from movingout.recordings.storage import listing
from movingout.recordings.storage.finished import recover
from movingout.recordings.storage.index import list_recordings
from movingout.world.state import WorldState
from tests.recordings.support import begin, header, play, record

INPUT: dict[str, Any] = {"tick": 1, "seat": 0, "seq": 1, "client_ms": 1.0, "move": 1, "heading": 0.0, "grabs": 0}
INPUT |= {"device": "keyboard", "rtt_ms": 5.0}
EVENT: dict[str, Any] = {"tick": 1, "kind": "grab", "seat": 0, "item": 1, "detail": ""}
NO_INPUTS: list[dict[str, Any]] = [{"seat": []}, {"seq": "1"}, {"move": None}, {"device": 3}, {"seat": 7}]
NO_EVENTS: list[dict[str, Any]] = [{"tick": "1"}, {"kind": [[1]]}, {"detail": {}}, {"seat": 9}]
Reader = Callable[[Mapping[str, Any]], object]


@pytest.mark.parametrize("time", ["9" * 30, "-" + "9" * 25, "253402300800000000000"])
def test_a_start_in_no_calendar_is_refused(time: str) -> None:
    records = header_metadata(header(), {})
    records[EPISODE]["started_ns"] = time
    with pytest.raises(RecordingError, match="in no calendar"):
        header_of(records, load_map("HandOff"))


@pytest.mark.parametrize(
    ("record_name", "key", "value"),
    [(RECORDING, "ticks", "9" * 30), (RECORDING, "ticks", "-1"), (RESULT, "tcr", "nan"), (RESULT, "items", "inf")],
)
def test_one_such_file_leaves_the_others_of_its_folder_listed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, record_name: str, key: str, value: str
) -> None:
    for name in ("good", "foreign"):
        finalise(record(tmp_path, ticks=2, episode_id=name)[0])
    read = listing.read_metadata

    def altered(path: Path) -> Mapping[str, Mapping[str, str]]:
        records = read(path)
        if path.name.startswith("foreign"):
            return {**records, record_name: {**records[record_name], key: value}}
        return records

    monkeypatch.setattr(listing, "read_metadata", altered)
    found, unreadable = list_recordings(tmp_path)
    assert [entry.id for entry in found] == ["good"]
    assert [entry.path.name for entry in unreadable] == ["foreign.mcap"]


@pytest.mark.parametrize(
    ("read", "payload"),
    [*((read_input, INPUT | one) for one in NO_INPUTS), *((read_event, EVENT | one) for one in NO_EVENTS)],
)
def test_a_value_of_another_kind_is_refused_where_it_is_read(read: Reader, payload: Mapping[str, Any]) -> None:
    with pytest.raises((TypeError, ValueError)):
        read(payload)


@pytest.mark.parametrize(
    "change",
    [
        {"held": np.array([4, -1])},
        {"held": np.array([-1, -2])},
        {"item_poses": np.zeros((1, 3))},
        {"item_poses": np.zeros((5, 3))},
    ],
)
def test_a_state_with_other_items_than_the_map_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: dict[str, Any]
) -> None:
    journal = record(tmp_path, ticks=3)[0]
    assert len(read_episode(journal).header.map.items) == 4
    read = payloads.read_state

    def altered(payload: Mapping[str, Any]) -> tuple[WorldState, tuple[bool, ...]]:
        state, delivered = read(payload)
        return (replace(state, **change) if state.tick == 2 else state), delivered

    monkeypatch.setattr(payloads, "read_state", altered)
    with pytest.raises(RecordingError, match="tick 2: other items than the 4 of its map"):
        read_episode(journal)


@pytest.mark.parametrize("item", [4, -2])
def test_a_ping_at_an_item_that_the_map_does_not_have_is_refused_and_stops_no_recovery(
    tmp_path: Path, item: int
) -> None:
    writer, played = begin(tmp_path, episode_id="foreign")
    play(writer, played, 2)
    writer.event(Event(2, "ping", 0, item))
    writer.close("time")
    record(tmp_path, ticks=2, episode_id="good")
    with pytest.raises(RecordingError, match="tick 2: a ping at none of the 4 items of its map"):
        read_episode(writer.path)
    recovered = {one.journal.name: one.recording is not None for one in recover(tmp_path)}
    assert recovered == {"foreign.mcap.journal": False, "good.mcap.journal": True}


def test_what_another_event_says_of_items_costs_nobody_a_recording(tmp_path: Path) -> None:
    writer, played = begin(tmp_path, episode_id="noted")
    play(writer, played, 2)
    writer.event(Event(2, "grab", 0, 4))
    writer.close("time")
    assert read_episode(writer.path).events[-1].item == 4


@pytest.mark.parametrize(("read", "payload"), [(read_input, INPUT), (read_event, EVENT)])
def test_what_rooms_write_is_read(read: Reader, payload: Mapping[str, Any]) -> None:
    assert read(payload)
