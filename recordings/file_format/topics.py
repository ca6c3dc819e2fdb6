"""The topics of a recording and their JSON schemas, field by field.

The schemas are the flat subset that strict viewers accept (every object with `properties`, arrays of scalars or
of such objects, no null, no references), so "nothing" is -1 or an empty string. `.payloads` writes and reads
what they describe; the topics that viewers draw are in `.foxglove`.
"""

from typing import Any, NamedTuple

from movingout.world.constants import TICK_MS
from movingout.world.metrics import METRICS, NO_VALUE, Metric

FORMAT_VERSION = 1
TICK_NS = TICK_MS * 1_000_000

Schema = dict[str, Any]


class Topic(NamedTuple):
    """A channel of the file; JSON unless `schema` is a protobuf descriptor set."""

    name: str
    schema_name: str
    schema: Schema


def _object(about: str, /, **properties: Schema) -> Schema:
    return {"type": "object", "description": about, "properties": properties, "required": list(properties)}


def _with_optional(schema: Schema, /, **properties: Schema) -> Schema:
    """An object with optional fields; they are left out where they do not apply, so that no wrong value is plotted."""
    return {**schema, "properties": {**schema["properties"], **properties}}


def _array(of: Schema, description: str) -> Schema:
    return {"type": "array", "items": of, "description": description}


def _integer(description: str) -> Schema:
    return {"type": "integer", "description": description}


def _number(description: str) -> Schema:
    return {"type": "number", "description": description}


def _metric(metric: Metric) -> Schema:
    return _number(metric.description + (f"; {NO_VALUE:g} when {metric.none_when}" if metric.none_when else ""))


def _string(description: str) -> Schema:
    return {"type": "string", "description": description}


_BOOLEAN: Schema = {"type": "boolean"}
_TICK = _integer(f"number of world steps made; 0 is the start, a tick is {TICK_MS} ms")
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
CANDIDATE = _object(
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
    kind=_string("start, grab, release, delivered, collision, pause, drop, deadline_missed, end, ..."),
    seat=_SEAT,
    item=_integer("index into items, -1 none"),
    detail=_string("for people"),
)
_AGENT = _with_optional(
    _object(
        "one answer of an agent; scores are left out where it told none",
        tick=_TICK,
        latency_ms=_number("observation to answer, -1 unknown (a match does not wait)"),
        missed=_BOOLEAN,
        chosen=_integer("index into scores and candidates, -1 none"),
        candidates=_array(CANDIDATE, "what it considered"),
        detail=_string("anything else, as JSON"),
    ),
    chosen_score=_number("of the candidate that it plays"),
    best_score=_number("the highest of all candidates"),
    mean_score=_number("over all candidates"),
    scores=_array(_number(""), "of every candidate, higher is better"),
)
_TIMING = _object(
    "how punctual the tick was", tick=_TICK, late_ms=_number("start after its due time"), blue=_NETWORK, red=_NETWORK
)
_METRICS = _object(
    "the metrics so far, derived",
    tick=_TICK,
    delivered=_integer("items delivered now"),
    **{metric.key: _metric(metric) for metric in METRICS},
)
_PINGS = _object(
    "a player asked for help, derived from the event",
    tick=_TICK,
    seat=_SEAT,
    item=_integer("index into items, -1 the player's own place"),
    x=_number("where that was, arena units"),
    y=_number("where that was, arena units"),
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
METRICS_TOPIC = Topic("/metrics", "movingout.Metrics", _METRICS)
PINGS_TOPIC = Topic("/pings", "movingout.Ping", _PINGS)
COMMIT = Topic("/commit", "movingout.Commit", _COMMIT)
JOURNAL_TOPICS = (*TRUTH, COMMIT)
CHANNELS = {topic.name: number for number, topic in enumerate(JOURNAL_TOPICS, start=1)}
"""Channel ids of format 1, the same in every journal."""
