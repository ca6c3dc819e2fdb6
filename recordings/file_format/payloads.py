"""The payloads of the truth topics: one JSON text per message, writing and reading side by side.

Floats are written with the shortest text that reads back to the same 64 bits.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import orjson

from movingout.maps import MapSpec, map_from_json, map_to_json
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.episode import AgentDecision, Event, InputSample, TickRecord
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.topics import CANDIDATE
from movingout.world.state import Floats, WorldState

Payload = Mapping[str, Any]


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
    blue, red = map(_action, record.actions.tolist(), record.sources, record.input_seqs)
    return encode({"tick": record.state.tick, "blue": blue, "red": red})


def _action(row: Sequence[float], source: str, seq: int) -> Payload:
    return {"distance": row[0], "heading": row[1], "grasp": row[2], "source": source, "input_seq": seq}


def write_timing(record: TickRecord) -> bytes:
    (blue_slack, red_slack), (blue_rtt, red_rtt) = record.slack_ms, record.rtt_ms
    return encode(
        {
            "tick": record.state.tick,
            "late_ms": record.late_ms,
            "blue": {"slack_ms": blue_slack, "rtt_ms": blue_rtt},
            "red": {"slack_ms": red_slack, "rtt_ms": red_rtt},
        }
    )


def read_tick(state: Payload, actions: Payload, timing: Payload) -> TickRecord:
    """One tick from its three payloads. Raises TypeError, KeyError or ValueError for payloads of another form."""
    after, delivered = read_state(state)
    blue, red = (actions[colour] for colour in SEAT_COLOURS)
    network = [timing[colour] for colour in SEAT_COLOURS]
    _require(str, blue["source"], red["source"])
    _require(int, blue["input_seq"], red["input_seq"])
    _require((int, float), timing["late_ms"], *(one[name] for one in network for name in ("slack_ms", "rtt_ms")))
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
    """Raises TypeError or ValueError for a payload of another form."""
    sample = InputSample(**payload)
    _require(int, sample.tick, sample.seat, sample.seq, sample.grabs)
    _require((int, float), sample.client_ms, sample.move, sample.heading, sample.rtt_ms)
    _require(str, sample.device)
    if sample.seat not in (0, 1):
        raise ValueError(f"an input of seat {sample.seat}")
    return sample


def write_event(event: Event) -> bytes:
    return encode(
        {"tick": event.tick, "kind": event.kind, "seat": event.seat, "item": event.item, "detail": event.detail}
    )


def read_event(payload: Payload) -> Event:
    """Raises TypeError or ValueError for a payload of another form."""
    event = Event(**payload)
    _require(int, event.tick, event.seat, event.item)
    _require(str, event.kind, event.detail)
    if event.seat not in (-1, 0, 1):
        raise ValueError(f"an event of seat {event.seat}")
    return event


def _require(kind: type | tuple[type, ...], *values: object) -> None:
    """Checksums vouch for the bytes of a file, not for who wrote it. Raises TypeError."""
    for value in values:
        if not isinstance(value, kind):
            raise TypeError(f"{value!r:.40} where another kind of value is needed")


def write_agent(decision: AgentDecision) -> bytes:
    """What viewers draw and plot gets fields of its own; whatever else an agent says is kept as JSON.

    Fields of their own: `chosen`; `candidates` of the schema's form; `scores`, or else the candidates' own.
    """
    rest = dict(decision.detail)
    chosen, candidates = _index(rest.get("chosen")), _candidates(rest.get("candidates"))
    for name, found in (("chosen", chosen >= 0), ("candidates", candidates)):
        if found:
            del rest[name]
    scores = _scores([one["score"] for one in candidates] if candidates else rest.get("scores"))
    if scores and not candidates:
        del rest["scores"]
    return orjson.dumps(
        {
            "tick": decision.tick,
            "latency_ms": decision.latency_ms,
            "missed": decision.missed,
            "chosen": chosen,
            "candidates": candidates,
            "detail": orjson.dumps(rest, option=orjson.OPT_SERIALIZE_NUMPY).decode() if rest else "",
            **_scored(scores, chosen),
        },
        option=orjson.OPT_SERIALIZE_NUMPY,
    )


def _index(value: object) -> int:
    return value if type(value) is int and value >= 0 else -1


def _candidates(value: object) -> Sequence[Payload]:
    """Those of the schema's form; none where one of them is not."""
    if not isinstance(value, list | tuple):
        return []
    described = all(isinstance(one, Mapping) and one.keys() == CANDIDATE["properties"].keys() for one in value)
    return value if described else []


def _scores(value: object) -> list[float]:
    """The scores of candidates; empty where that is no list of finite numbers."""
    told = value.tolist() if isinstance(value, np.ndarray) else value
    if not isinstance(told, list | tuple) or not all(type(one) in (int, float) and math.isfinite(one) for one in told):
        return []
    return list(told)


def _scored(scores: Sequence[float], chosen: int) -> Payload:
    """The fields that plot, where anything was scored."""
    if not scores:
        return {}
    own = {"chosen_score": scores[chosen]} if 0 <= chosen < len(scores) else {}
    return {**own, "best_score": max(scores), "mean_score": sum(scores) / len(scores), "scores": scores}


def read_agent(payload: Payload, seat: int) -> AgentDecision:
    """Files that were made before scores had fields of their own have them in `detail`."""
    detail: dict[str, object] = orjson.loads(payload["detail"]) if payload["detail"] else {}
    if payload["chosen"] != -1:
        detail["chosen"] = payload["chosen"]
    if payload["candidates"]:
        detail["candidates"] = payload["candidates"]
    elif payload.get("scores"):
        detail["scores"] = payload["scores"]
    return AgentDecision(payload["tick"], seat, payload["latency_ms"], payload["missed"], detail)
