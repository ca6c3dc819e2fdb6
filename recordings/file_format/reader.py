"""Reads a recording, finished or a journal; checksums are verified before any value is used."""

import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast, get_args

import orjson
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Header, Metadata
from zstandard import ZstdError

from movingout.maps.errors import MapError
from movingout.maps.files.input_file import read_input
from movingout.recordings.episode import AgentDecision, Episode, Event, InputSample, Outcome, TickRecord
from movingout.recordings.errors import RecordingError, UnreadableError, cannot
from movingout.recordings.file_format import payloads
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX, PROFILE, scan
from movingout.recordings.file_format.metadata import END, RECORDING, SOFTWARE, Entries, episode_record, header_of
from movingout.recordings.file_format.records import DATA_END, FOOTER, MAGIC, Message, Record, records_of
from movingout.world.state import WorldState

_RESCUE = "copy it again from where it was recorded, or save what is whole: movingout recordings recover FILE"
LARGEST = 1 << 32  # bytes of a recording
UNREADABLE = (
    McapError,
    ZstdError,
    struct.error,
    ValueError,
    KeyError,
    TypeError,
    IndexError,
    OverflowError,
    MemoryError,
)


def read_episode(path: Path | str) -> Episode:
    """The episode in a finished recording or in a journal (then: its whole ticks so far).

    RecordingError when there is no file, when it is of another kind or a newer format, or when bytes are damaged.
    """
    if not isinstance(path, str | Path):
        raise RecordingError(f"a recording is named by the path of its file, not by {path!r:.80}")
    path = Path(path)
    data = read_bytes(path)
    if path.name.endswith(JOURNAL_SUFFIX):
        found = scan(data)
        return episode_of_journal(data[: found.end], path.name, found.damage)
    check_file(data, path.name)
    return _episode(records_of(data), path.name)


def episode_of_journal(data: bytes, name: str, damage: str = "") -> Episode:
    """The episode of a journal's trusted bytes. Raises UnreadableError."""
    if not data:
        raise UnreadableError(f"{name} has no complete header, so nothing in it can be read")
    return _episode(records_of(data), name, damage)


def read_bytes(path: Path) -> bytes:
    """Raises RecordingError."""
    try:
        return read_input(path, LARGEST)
    except OSError as error:
        raise cannot("read", path, error) from error


def check_file(data: bytes, name: str) -> None:
    """Raise RecordingError unless `data` is a complete recording of this project with all checksums right."""
    if not data:
        raise UnreadableError(f"{name} is empty")
    if not data.startswith(MAGIC):
        raise UnreadableError(f"{name} is not an MCAP file")
    if header_profile(data) != PROFILE:
        raise UnreadableError(f"{name} is an MCAP file, but not a Moving Out recording")
    if not data.endswith(MAGIC) or len(data) < 2 * len(MAGIC) + FOOTER.size + DATA_END.size:
        raise UnreadableError(f"{name} is incomplete: its end is missing; {_RESCUE}")
    foot = len(data) - len(MAGIC) - FOOTER.size
    opcode, length, summary, _, summary_crc = FOOTER.unpack_from(data, foot)
    end = summary - DATA_END.size
    if (opcode, length) != (0x02, 20) or not len(MAGIC) < end <= foot - DATA_END.size:
        raise UnreadableError(f"{name} is damaged: its footer changed after it was written; {_RESCUE}")
    if DATA_END.unpack_from(data, end) != (0x0F, 4, zlib.crc32(data[:end])):
        raise UnreadableError(f"{name} is damaged: bytes of its data changed after they were written; {_RESCUE}")
    if zlib.crc32(data[summary : len(data) - len(MAGIC) - 4]) != summary_crc:
        raise UnreadableError(f"{name} is damaged: bytes of its index changed after they were written; {_RESCUE}")


def header_profile(data: bytes) -> str:
    """The profile that the file declares; empty when there is no readable header."""
    try:
        first = next(records_of(data[:4096]), None)
    except UNREADABLE:
        return ""
    return first.profile if isinstance(first, Header) else ""


@dataclass
class _Collected:
    """The decoded records of a file, from which the Episode is made."""

    keepers: dict[int, Callable[[Any], None]] = field(default_factory=dict)  # by channel id
    metadata: dict[str, Entries] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    the_map: Any = None
    states: list[Any] = field(default_factory=list)
    actions: list[Any] = field(default_factory=list)
    timing: list[Any] = field(default_factory=list)
    inputs: list[InputSample] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    decisions: list[AgentDecision] = field(default_factory=list)
    returns: Counter[int] = field(default_factory=Counter)  # of each seat, so far

    def take(self, record: Record) -> None:
        match record:
            case Message():
                keep = self.keepers.get(record.channel_id)
                if keep is not None:
                    keep(orjson.loads(record.data))
            case Channel():
                if record.topic in (keepers := self._by_topic()):
                    self.keepers[record.id] = keepers[record.topic]
            case Metadata():
                self.metadata[record.name] = record.metadata
            case Attachment():
                self.attachments[record.name] = record.data

    def _by_topic(self) -> dict[str, Callable[[Any], None]]:
        return {
            "/map": self._keep_map,
            "/state": self.states.append,
            "/actions": self.actions.append,
            "/timing": self.timing.append,
            "/inputs": self._keep_input,
            "/events": self._keep_event,
            "/agent/blue": lambda payload: self.decisions.append(payloads.read_agent(payload, 0)),
            "/agent/red": lambda payload: self.decisions.append(payloads.read_agent(payload, 1)),
        }

    def _keep_map(self, payload: Any) -> None:
        self.the_map = payload

    def _keep_input(self, payload: Any) -> None:
        sample = payloads.read_input(payload)
        self.inputs.append(sample._replace(connection=self.returns[sample.seat]))

    def _keep_event(self, payload: Any) -> None:
        event = payloads.read_event(payload)
        self.events.append(event)
        if event.kind == "return":
            self.returns[event.seat] += 1


def _episode(records: Iterable[Record], name: str, damage: str = "") -> Episode:
    found = _Collected()
    try:
        for record in records:
            found.take(record)
        episode_record(found.metadata)
        if found.the_map is None or not found.states:
            raise UnreadableError("the map or the start is missing")
        return _build(found, damage)
    except (RecordingError, MapError) as error:
        raise UnreadableError(f"{name}: {error}") from error
    except UNREADABLE as error:
        raise UnreadableError(f"{name} lacks what a recording of format 1 must contain: {error!r}") from error


def _build(found: _Collected, damage: str) -> Episode:
    ticks = tuple(
        payloads.read_tick(*three) for three in zip(found.states[1:], found.actions, found.timing, strict=False)
    )
    _require_consecutive(ticks, len(found.states), len(found.actions))
    header = header_of(found.metadata, payloads.read_map(found.the_map))
    initial = payloads.read_state(found.states[0])[0]
    _require_bodies((initial, *(tick.state for tick in ticks)), len(header.map.items))
    _require_pinged_items(found.events, len(header.map.items))
    closing = found.metadata.get(RECORDING, {})
    damage = damage or closing.get("damage", "")
    outcome = _outcome(found.metadata.get(END, {}))
    return Episode(
        header=header,
        initial=initial,
        ticks=ticks,
        inputs=tuple(found.inputs),
        events=tuple(found.events),
        decisions=tuple(found.decisions),
        outcome=outcome,
        ended_ns=int(found.metadata.get(END, {}).get("ended_ns", "0")),
        complete=outcome != "interrupted" and not damage,
        damage=damage,
        versions=dict(found.metadata.get(SOFTWARE, {})),
        attachments=found.attachments,
    )


def _outcome(end: Entries) -> Outcome:
    outcome = end.get("outcome", "interrupted")
    if outcome not in get_args(Outcome):
        raise UnreadableError(f"unknown outcome {outcome!r}; known: {', '.join(get_args(Outcome))}")
    return cast(Outcome, outcome)


def _require_bodies(states: Iterable[WorldState], items: int) -> None:
    """Every state has the items of the map, and robots hold none but these: -1 is no item."""
    for state in states:
        if len(state.item_poses) != items or any(not -1 <= held < items for held in state.held.tolist()):
            raise UnreadableError(f"tick {state.tick}: other items than the {items} of its map")


def _require_pinged_items(events: Iterable[Event], items: int) -> None:
    """Pings are at the items of the map: -1 is the robot's own place. In other events an item is a note."""
    for event in events:
        if event.kind == "ping" and not -1 <= event.item < items:
            raise UnreadableError(f"tick {event.tick}: a ping at none of the {items} items of its map")


def _require_consecutive(ticks: tuple[TickRecord, ...], states: int, actions: int) -> None:
    numbers = [tick.state.tick for tick in ticks]
    if numbers != list(range(1, states)) or actions != states - 1:
        raise UnreadableError(f"ticks are missing: {states - 1} states, {actions} actions")
