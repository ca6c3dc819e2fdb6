"""Recordings as three tables: episodes, ticks, events. One list of columns makes the rows and the data dictionary."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import orjson

from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.episode import ROOM_PSEUDONYM, Episode, TickRecord
from movingout.recordings.exports.split import SplitBy
from movingout.recordings.file_format.derived_topics import result
from movingout.recordings.file_format.metadata import utc
from movingout.world.constants import TICK_SECONDS
from movingout.world.metrics import METRICS, EpisodeMetrics, Metric
from movingout.world.observation import ITEM_SLOTS, LAYOUTS, encoder
from movingout.world.own_metrics import own_metrics, own_values
from movingout.world.state import WorldState

ColumnType = Literal["string", "int64", "float64", "bool", "list<float32>"]
Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Column:
    """One column with its entry in the data dictionary."""

    name: str
    type: ColumnType
    unit: str
    meaning: str


Entry = tuple[str, ColumnType, str, str]  # name, type, unit, meaning


def _columns(*entries: Entry) -> list[Column]:
    return [Column(*entry) for entry in entries]


def _prefixed(prefix: str, entries: Sequence[Entry]) -> list[Entry]:
    return [(f"{prefix}_{name}", kind, unit, meaning) for name, kind, unit, meaning in entries]


def _metric_columns(metrics: Sequence[Metric] = METRICS, when: str = "") -> list[Entry]:
    return [(metric.key, "float64", metric.bounds, when + metric.documentation) for metric in metrics]


_SEAT: list[Entry] = [
    ("kind", "string", "", "who sat in the seat: human, agent, remote, ghost, idle"),
    ("name", "string", "", "pseudonym of the person, or id of the agent"),
    ("checkpoint", "string", "", "SHA-256 of the agent's weights, empty for people"),
    ("device", "string", "", "keyboard, gamepad, touch; empty for agents"),
]

EPISODES = _columns(
    ("episode_id", "string", "", "joins the three tables; the file is <episode_id>.mcap"),
    ("map", "string", "", "name of the map; of different maps with one name, NAME.1, NAME.2, ..."),
    ("map_variant", "string", "", "randomisation of the map, empty for the map as designed"),
    ("seed", "int64", "", "seed of the episode"),
    ("started_utc", "string", "ISO 8601", "start on the wall clock"),
    ("source", "string", "", "live, match, scripted or import"),
    ("outcome", "string", "", "delivered, time, left, stopped, error or interrupted"),
    ("complete", "bool", "", "ended, and nothing of it is missing"),
    ("ticks", "int64", "tick", f"length; a tick is {TICK_SECONDS} s"),
    ("limit_ticks", "int64", "tick", "time limit, 0 for none"),
    *_prefixed("blue", _SEAT),
    *_prefixed("red", _SEAT),
    ("delivered", "int64", "items", "delivered at the end"),
    ("items", "int64", "items", "on the map"),
    *_metric_columns((*METRICS, *own_metrics())),
    ("split", "string", "", "train or test"),  # `tables_of` says what is in one of the two as a whole
    ("study", "string", "JSON", "pseudonymous ids of the study"),
    ("pymunk", "string", "", "version of the physics engine"),
)
EVENTS = _columns(
    ("episode_id", "string", "", "joins the three tables"),
    ("tick", "int64", "tick", "when"),
    ("time_s", "float64", "s", "when, as time of play"),
    (
        "kind",
        "string",
        "",
        "start, grab, grab_failed, release, delivered, collision, pause, drop, end, ...",
    ),
    ("seat", "string", "", "blue, red, or empty when it concerns the room"),
    ("item", "int64", "", "index of the item, -1 for none"),
    ("detail", "string", "", "one line for people"),
)
_ROBOT: list[Entry] = [
    ("x", "float64", "arena units", "position after the tick"),
    ("y", "float64", "arena units", "position after the tick"),
    ("angle", "float64", "rad", "0 looks along +y, counter-clockwise, not wrapped"),
    ("vx", "float64", "units/s", "velocity"),
    ("vy", "float64", "units/s", "velocity"),
    ("angular_velocity", "float64", "rad/s", "angular velocity"),
    ("held", "int64", "", "index of the held item, -1 for none"),
    ("distance", "float64", "[-1, 1]", "the action that made this tick: drive; empty in row 0"),
    ("heading", "float64", "rad", "the action: where to look; empty in row 0"),
    ("grasp", "float64", "{0, 1}", "the action: 1 toggles the grasp; empty in row 0"),
    ("action_source", "string", "", "human, agent, remote, ghost, idle or neutral (nobody answered)"),
    ("input_seq", "int64", "", "sequence number of the raw input used, -1 for none"),
]
_ITEM: list[Entry] = [
    ("x", "float64", "arena units", "position; empty when the map has fewer items"),
    ("y", "float64", "arena units", "position"),
    ("angle", "float64", "rad", "angle, not wrapped"),
    ("delivered", "bool", "", "lies wholly in a goal"),
]
TICKS = _columns(
    ("episode_id", "string", "", "joins the three tables"),
    ("tick", "int64", "tick", "0 is the start, before any action"),
    ("time_s", "float64", "s", f"tick x {TICK_SECONDS}"),
    *_prefixed("blue", _ROBOT),
    *_prefixed("red", _ROBOT),
    *(entry for slot in range(ITEM_SLOTS) for entry in _prefixed(f"item_{slot}", _ITEM)),
    ("late_ms", "float64", "ms", "start of the tick after its due time"),
    ("delivered", "int64", "items", "delivered now"),
    *_metric_columns(when="so far: "),
)
TABLES = {"episodes": EPISODES, "ticks": TICKS, "events": EVENTS}
_DIVIDED: dict[SplitBy, str] = {
    "participant": f"no participant is in both; who played outside a study has a name {ROOM_PSEUDONYM}… per room",
    "episode": "a participant may be in both",
    "map": "no map is in both, a participant may be",
}


def tables_of(split_by: SplitBy) -> dict[str, list[Column]]:
    """The tables of an export, with what its split keeps apart."""
    meaning = f"train or test; {_DIVIDED[split_by]}"
    episodes = [replace(column, meaning=meaning) if column.name == "split" else column for column in EPISODES]
    return {**TABLES, "episodes": episodes}


def observation_columns(layout: str) -> list[Column]:
    """What each seat sees after the tick, as policies get it."""
    size = LAYOUTS[layout].size
    meaning = f"ego-centric vector of {size} numbers, layout {layout} (world/observation/layouts.py)"
    if LAYOUTS[layout].own_frame:
        meaning += (
            "; its directions are relative to the own angle, those of the columns heading and angle are the arena's"
        )
    return [Column(f"{colour}_observation", "list<float32>", "", meaning) for colour in SEAT_COLOURS]


def episode_row(episode: Episode, split: str) -> Row:
    header = episode.header
    numbers = result(episode)
    row: Row = {
        "episode_id": header.episode_id,
        "map": header.map.name,
        "map_variant": header.map.variant,
        "seed": header.seed,
        "started_utc": utc(header.started_ns),
        "source": header.source,
        "outcome": episode.outcome,
        "complete": episode.complete,
        "ticks": len(episode.ticks),
        "limit_ticks": header.limit_ticks,
        "delivered": sum(episode.delivered_after(len(episode.ticks))),
        "items": len(header.map.items),
        **{metric.key: numbers[metric.key] for metric in METRICS},
        **own_values(header.map, episode.states, episode.actions),
        "split": split,
        "study": orjson.dumps(dict(header.study)).decode(),
        "pymunk": episode.versions.get("pymunk", ""),
    }
    for colour, seat in zip(SEAT_COLOURS, header.seats, strict=True):
        row |= {f"{colour}_kind": seat.kind, f"{colour}_name": seat.name, f"{colour}_device": seat.device}
        row[f"{colour}_checkpoint"] = seat.checkpoint_sha256
    return row


def event_rows(episode: Episode) -> Iterator[Row]:
    for event in episode.events:
        yield {
            "episode_id": episode.header.episode_id,
            "tick": event.tick,
            "time_s": round(event.tick * TICK_SECONDS, 3),
            "kind": event.kind,
            "seat": SEAT_COLOURS[event.seat] if event.seat >= 0 else "",
            "item": event.item,
            "detail": event.detail,
        }


def tick_rows(episode: Episode, layout: str = "") -> Iterator[Row]:
    """One row per state, the start first; with a layout also what each seat sees."""
    metrics = EpisodeMetrics(episode.header.map)
    encode = encoder(episode.header.map, layout).encode_both if layout else None
    before = episode.initial
    start = _start_row(episode.initial, episode.delivered_after(0))
    for number, state in enumerate(episode.states):
        row = start
        if number:
            tick = episode.ticks[number - 1]
            metrics.update(before, tick.actions, state)
            row = _made_row(tick)
        row |= {"episode_id": episode.header.episode_id, "tick": number, "time_s": round(number * TICK_SECONDS, 3)}
        row |= metrics.result().values()
        if encode is not None:
            for colour, seen in zip(SEAT_COLOURS, encode(state), strict=True):
                row[f"{colour}_observation"] = seen.astype(np.float32)
        yield row
        before = state


def _start_row(state: WorldState, delivered: Sequence[bool]) -> Row:
    return _state_row(state, delivered) | {"delivered": sum(delivered)}


def _made_row(tick: TickRecord) -> Row:
    """The state after a tick and the actions that made it."""
    row = _state_row(tick.state, tick.delivered) | {"delivered": sum(tick.delivered), "late_ms": tick.late_ms}
    for seat, colour in enumerate(SEAT_COLOURS):
        row |= _named(colour, _ROBOT[7:], [*tick.actions[seat].tolist(), tick.sources[seat], tick.input_seqs[seat]])
    return row


def _state_row(state: WorldState, delivered: Sequence[bool]) -> Row:
    row: Row = {}
    robots = np.hstack([state.robot_poses, state.robot_velocities]).tolist()
    for seat, colour in enumerate(SEAT_COLOURS):
        row |= _named(colour, _ROBOT[:7], [*robots[seat], int(state.held[seat])])
    for slot, pose in enumerate(state.item_poses.tolist()):
        row |= _named(f"item_{slot}", _ITEM, [*pose, bool(delivered[slot])])
    return row


def _named(prefix: str, columns: Sequence[Entry], values: Sequence[Any]) -> Row:
    return {f"{prefix}_{column[0]}": value for column, value in zip(columns, values, strict=True)}


def data_dictionary(describe: Callable[[str], str], tables: dict[str, list[Column]]) -> str:
    """The data dictionary as a page; `describe` names the file of a table."""
    lines = [
        "# Data dictionary",
        "",
        "Made with the export. Empty cells mean that something does not apply. A row of `ticks` is the state after the",
        "tick beside the action that made it; pair row t with the action of row t + 1 to train a policy.",
    ]
    for name, columns in tables.items():
        lines += ["", f"## {name} (`{describe(name)}`)", "", "| column | type | unit | meaning |", "|---|---|---|---|"]
        lines += [f"| `{c.name}` | {c.type} | {c.unit} | {c.meaning} |" for c in columns]
    return "\n".join(lines) + "\n"
