"""The truth topics of a recording: one JSON payload per kind, writing and reading side by side.

The schemas are the flat subset that strict viewers accept (every object with `properties`, arrays of scalars or
of such objects, no null, no references), so "nothing" is -1 or an empty string. Floats are written with the
shortest text that reads back to the same 64 bits. Topics that can be derived from these live in `foxglove`.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import orjson

from maps import MapSpec
from maps.json_format import map_from_json, map_to_json
from maps.spec import SEAT_COLOURS
from recordings.episode import AgentDecision, Event, InputSample, TickRecord
from recordings.errors import RecordingError
from world.state import Floats, WorldState

FORMAT_VERSION = 1
TICK_NS = 100_000_000

Schema = dict[str, Any]
Payload = Mapping[str, Any]


class Topic(NamedTuple):
    """A channel of the file; JSON unless `schema` is a protobuf descriptor set."""

    name: str
    schema_name: str
    schema: Schema


def _object(about: str, /, **properties: Schema) -> Schema:
    return {"type": "object", "description": about, "properties": properties, "required": list(properties)}


def _array(of: Schema, description: str) -> Schema:
    return {"type": "array", "items": of, "description": description}


def _integer(description: str) -> Schema:
    return {"type": "integer", "description": description}


def _number(description: str) -> Schema:
    return {"type": "number", "description": description}


def _string(description: str) -> Schema:
    return {"type": "string", "description": description}


_BOOLEAN: Schema = {"type": "boolean"}
_TICK = _integer("number of world steps made; 0 is the start, a tick is 100 ms")
_SEAT = _integer("0 blue, 1 red, -1 nobody")
_POSE = {"x": _number("arena units"), "y": _number("arena units"), "angle": _number("radians, not wrapped")}
_RECT = _object("", x0=_number("corner"), y0=_number("corner"), x1=_number("other corner"), y1=_number("other corner"))
_ROBOT = _object(
    "",
    **_POSE,
    vx=_number("units/s"),
    vy=_number("units/s"),
    angular_velocity=_number("rad/s"),
    held=_integer("index into items, -1 none"),
)
_ACTION = _object(
    "exactly what the world was given",
    distance=_number("nominally [-1, 1]"),
    heading=_number("radians"),
    grasp=_number("1 toggles the grasp"),
    source=_string("human, agent, remote, ghost, idle, neutral (nobody answered)"),
    input_seq=_integer("sequence number of the input used, -1 none"),
)
_NETWORK = _object(
    "",
    slack_ms=_number("how long before the tick the newest input came, -1 unknown"),
    rtt_ms=_number("round trip, -1 unknown"),
)
_CANDIDATE = _object(
    "",
    score=_number("higher is better"),
    terms=_array(_number(""), "parts of the score"),
    x=_array(_number(""), "predicted path, arena units"),
    y=_array(_number(""), "predicted path, arena units"),
)

_MAP = _object(
    "the map that was played",
    format=_integer("version of the map format"),
    name=_string("identifier"),
    title=_string("for people"),
    number=_integer("1-12 as in the paper, 0 other"),
    mode=_string("coordination, awareness, action consistency, practice"),
    description=_string("one line"),
    robots=_object("start poses", blue=_object("", **_POSE), red=_object("", **_POSE)),
    walls=_array(_RECT, "axis-aligned"),
    goals=_array(_RECT, "axis-aligned"),
    items=_array(
        _object(
            "",
            id=_integer("official id"),
            shape=_string("triangle, square, ..."),
            size=_string("small, middle, large"),
            scale=_number("radius of the circle of the same area"),
            mass=_number("as the official map files give it"),
            **_POSE,
        ),
        "in the order of every item array",
    ),
)
_STATE = _object(
    "the world after the tick, exact to the bit",
    tick=_TICK,
    blue=_ROBOT,
    red=_ROBOT,
    items=_array(_object("", id=_integer("of the map"), **_POSE, delivered=_BOOLEAN), "in the map's order"),
)
_ACTIONS = _object("the actions that made this tick", tick=_TICK, blue=_ACTION, red=_ACTION)
_INPUTS = _object(
    "a raw input as it arrived",
    tick=_integer("the tick being prepared"),
    seat=_SEAT,
    seq=_integer("the client's sequence number"),
    client_ms=_number("the client's clock"),
    move=_number("[-1, 1]"),
    heading=_number("radians"),
    grabs=_integer("presses so far, modulo 256"),
    device=_string("keyboard, gamepad, touch, program"),
    rtt_ms=_number("round trip"),
)
_EVENTS = _object(
    "something that happened",
    tick=_TICK,
    kind=_string("start, grab, release, delivered, pause, drop, deadline_missed, end, ..."),
    seat=_SEAT,
    item=_integer("index into items, -1 none"),
    detail=_string("for people"),
)
_AGENT = _object(
    "one answer of an agent",
    tick=_TICK,
    latency_ms=_number("observation to answer"),
    missed=_BOOLEAN,
    chosen=_integer("index into candidates, -1 none"),
    candidates=_array(_CANDIDATE, "what it considered"),
    detail=_string("anything else, as JSON"),
)
_TIMING = _object(
    "how punctual the tick was", tick=_TICK, late_ms=_number("start after its due time"), blue=_NETWORK, red=_NETWORK
)
_METRICS = _object(
    "the paper's metrics so far, derived",
    tick=_TICK,
    delivered=_integer("items delivered now"),
    tcr=_number("task completion rate, [0, 1]"),
    nfd=_number("normalised final distance, 1 when all is home"),
    wt_s=_number("waiting time of both together, seconds"),
    ac=_number("action consistency, [0, 1], -1 before anything is carried together"),
)
_COMMIT = _object(
    "closes a tick in a journal: everything before it is whole",
    commit=_TICK,
    offset=_integer("bytes before this record"),
    crc32=_integer("of all bytes before this record, then tick and log time (<QQ)"),
)

TRUTH = (
    Topic("/map", "movingout.Map", _MAP),
    Topic("/state", "movingout.State", _STATE),
    Topic("/actions", "movingout.Actions", _ACTIONS),
    Topic("/inputs", "movingout.Input", _INPUTS),
    Topic("/events", "movingout.Event", _EVENTS),
    Topic("/agent/blue", "movingout.AgentDecision", _AGENT),
    Topic("/agent/red", "movingout.AgentDecision", _AGENT),
    Topic("/timing", "movingout.Timing", _TIMING),
)
METRICS = Topic("/metrics", "movingout.Metrics", _METRICS)
COMMIT = Topic("/commit", "movingout.Commit", _COMMIT)
JOURNAL_TOPICS = (*TRUTH, COMMIT)
CHANNELS = {topic.name: number for number, topic in enumerate(JOURNAL_TOPICS, start=1)}
"""Channel ids of format 1, the same in every journal."""


def encode(payload: Payload) -> bytes:
    return orjson.dumps(payload)


def finite(payload: bytes) -> bytes:
    """The payload of numbers, or a RecordingError: orjson writes NaN and infinity as null.

    Only for payloads without free text.
    """
    if b"null" in payload:
        raise RecordingError(f"a number is not finite, so this tick cannot be recorded: {payload[:200].decode()}")
    return payload


# ---- map ---------------------------------------------------------------------------------------------------


def write_map(spec: MapSpec) -> bytes:
    return orjson.dumps(map_to_json(spec), option=orjson.OPT_INDENT_2)


def read_map(payload: Payload) -> MapSpec:
    return map_from_json(dict(payload))


# ---- state -------------------------------------------------------------------------------------------------


def _robot(pose: Sequence[float], velocity: Sequence[float], held: int) -> Payload:
    return {
        "x": pose[0],
        "y": pose[1],
        "angle": pose[2],
        "vx": velocity[0],
        "vy": velocity[1],
        "angular_velocity": velocity[2],
        "held": held,
    }


def write_state(state: WorldState, delivered: Sequence[bool], item_ids: Sequence[int]) -> bytes:
    poses, velocities, held = state.robot_poses.tolist(), state.robot_velocities.tolist(), state.held.tolist()
    return encode(
        {
            "tick": state.tick,
            "blue": _robot(poses[0], velocities[0], held[0]),
            "red": _robot(poses[1], velocities[1], held[1]),
            "items": [
                {"id": item, "x": x, "y": y, "angle": angle, "delivered": done}
                for item, (x, y, angle), done in zip(item_ids, state.item_poses.tolist(), delivered, strict=True)
            ],
        }
    )


def read_state(payload: Payload) -> tuple[WorldState, tuple[bool, ...]]:
    """The state and which items were delivered."""
    robots = [payload[colour] for colour in SEAT_COLOURS]
    items = payload["items"]
    state = WorldState(
        tick=payload["tick"],
        robot_poses=_floats([(r["x"], r["y"], r["angle"]) for r in robots]),
        robot_velocities=_floats([(r["vx"], r["vy"], r["angular_velocity"]) for r in robots]),
        held=np.array([r["held"] for r in robots], dtype=np.int64),
        item_poses=_floats([(item["x"], item["y"], item["angle"]) for item in items]),
    )
    return state, tuple(item["delivered"] for item in items)


def _floats(rows: list[tuple[float, float, float]]) -> Floats:
    return np.array(rows, dtype=np.float64).reshape(len(rows), 3)


# ---- actions and timing ------------------------------------------------------------------------------------


def write_actions(record: TickRecord) -> bytes:
    blue, red = (
        {"distance": row[0], "heading": row[1], "grasp": row[2], "source": source, "input_seq": seq}
        for row, source, seq in zip(record.actions.tolist(), record.sources, record.input_seqs, strict=True)
    )
    return encode({"tick": record.state.tick, "blue": blue, "red": red})


def write_timing(record: TickRecord) -> bytes:
    blue, red = ({"slack_ms": slack, "rtt_ms": rtt} for slack, rtt in zip(record.slack_ms, record.rtt_ms, strict=True))
    return encode({"tick": record.state.tick, "late_ms": record.late_ms, "blue": blue, "red": red})


def read_tick(state: Payload, actions: Payload, timing: Payload) -> TickRecord:
    """One tick from its three payloads."""
    after, delivered = read_state(state)
    blue, red = (actions[colour] for colour in SEAT_COLOURS)
    network = [timing[colour] for colour in SEAT_COLOURS]
    return TickRecord(
        actions=_floats([(a["distance"], a["heading"], a["grasp"]) for a in (blue, red)]),
        sources=(blue["source"], red["source"]),
        input_seqs=(blue["input_seq"], red["input_seq"]),
        state=after,
        delivered=delivered,
        late_ms=timing["late_ms"],
        slack_ms=(network[0]["slack_ms"], network[1]["slack_ms"]),
        rtt_ms=(network[0]["rtt_ms"], network[1]["rtt_ms"]),
    )


# ---- inputs, events, agents --------------------------------------------------------------------------------


def write_input(sample: InputSample) -> bytes:
    return encode(
        {
            "tick": sample.tick,
            "seat": sample.seat,
            "seq": sample.seq,
            "client_ms": sample.client_ms,
            "move": sample.move,
            "heading": sample.heading,
            "grabs": sample.grabs,
            "device": sample.device,
            "rtt_ms": sample.rtt_ms,
        }
    )


def read_input(payload: Payload) -> InputSample:
    return InputSample(**payload)


def write_event(event: Event) -> bytes:
    return encode(
        {"tick": event.tick, "kind": event.kind, "seat": event.seat, "item": event.item, "detail": event.detail}
    )


def read_event(payload: Payload) -> Event:
    return Event(**payload)


def write_agent(decision: AgentDecision) -> bytes:
    """`chosen` and well-formed `candidates` get fields of their own; whatever else an agent says is kept as JSON."""
    rest = dict(decision.detail)
    chosen = rest.pop("chosen", -1) if isinstance(rest.get("chosen"), int) else -1
    candidates = rest.pop("candidates", []) if _are_candidates(rest.get("candidates")) else []
    return orjson.dumps(
        {
            "tick": decision.tick,
            "latency_ms": decision.latency_ms,
            "missed": decision.missed,
            "chosen": chosen,
            "candidates": candidates,
            "detail": orjson.dumps(rest, option=orjson.OPT_SERIALIZE_NUMPY).decode() if rest else "",
        },
        option=orjson.OPT_SERIALIZE_NUMPY,
    )


def _are_candidates(value: object) -> bool:
    return isinstance(value, list | tuple) and all(
        isinstance(entry, Mapping) and entry.keys() == _CANDIDATE["properties"].keys() for entry in value
    )


def read_agent(payload: Payload, seat: int) -> AgentDecision:
    detail: dict[str, object] = orjson.loads(payload["detail"]) if payload["detail"] else {}
    if payload["chosen"] != -1:
        detail["chosen"] = payload["chosen"]
    if payload["candidates"]:
        detail["candidates"] = payload["candidates"]
    return AgentDecision(payload["tick"], seat, payload["latency_ms"], payload["missed"], detail)
