"""Writes web/messages.js from `server.messages`, `server.frames`, `world.metrics`, `recordings.episode` and questions.

Run `python -m movingout.server.messages_js`. The file has constants, the table of metrics, an encode and a decode
function per binary frame, and a JSDoc type per control message. Nothing in the browser client restates a byte offset, a
code, a field, a metric or a value of an answer (`study.questionnaire`).
"""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, get_args, get_origin

import msgspec

from movingout.recordings.episode import FINISHED, Outcome
from movingout.server import messages as m
from movingout.server.frame_layout import SIZES, Form, FrameLayout, Packed, Wire
from movingout.server.frames import Beat, Bundle, BundleEvent, Input, Ping, Pong, WirePose
from movingout.study import questionnaire
from movingout.world.metrics import METRICS, NO_VALUE

TARGET = Path(__file__).parent.parent / "web" / "messages.js"

NUMBER_NAMES = (
    "PROTOCOL", "TICK_MS", "POSES_PER_TICK", "LIMIT_TICKS", "INVITED_S", "PING_TICKS", "REACH", "REACH_TOLERANCE",
    "CORNER_FRACTION", "ARENA_HALF", "ROBOT_RADIUS", "WALL_MARGIN",
    "BUNDLE", "BEAT", "INPUT", "PING", "PONG", "POSITION_SCALE", "ANGLE_SCALE", "AXIS_SCALE", "SLACK_SCALE",
    "FLAG_NOT_RECORDING", "FLAG_SKIPPED",
)  # fmt: skip
ANSWER_NAMES = ("LIKERT_MIN", "LIKERT_MAX", "TLX_MAX", "NO_ANSWER", "TEXT_LIMIT")
CLOSE_NAMES = tuple(name for name in vars(m) if name.startswith("CLOSE_"))
SCALE_NAMES = {getattr(m, name): name for name in NUMBER_NAMES if name.endswith("_SCALE")}
ACCESSORS = {"B": "Uint8", "b": "Int8", "H": "Uint16", "h": "Int16", "I": "Uint32", "d": "Float64"}
TYPES = {Form.ONE: "number", Form.EACH_SEAT: "[number, number]", Form.FLAGS: "boolean[]"}
FIXED_FRAMES: tuple[type[Packed], ...] = (Beat, Input, Ping, Pong)


def generate() -> str:
    """The whole text of web/messages.js."""
    parts = [
        "// Generated from server/messages.py, server/frames.py, world/metrics.py, recordings/episode.py and\n"
        "// study/questionnaire.py by `python -m movingout.server.messages_js`.\n"
        "// Do not edit. The conversation is explained in docs/protocol.md.",
        _constants(),
        _answers(),
        _metrics(),
        _frozen_list("FINISHED", tuple(one for one in get_args(Outcome) if one in FINISHED)),
        *(_fixed_frame(frame) for frame in FIXED_FRAMES),
        _bundle(),
        _control_types(),
    ]
    return "\n\n".join(parts) + "\n"


# ---- constants ----------------------------------------------------------------------------------------------


def _constants() -> str:
    lines = [f"export const SUBPROTOCOL = {_js(m.SUBPROTOCOL)};"]
    lines += [f"export const {name} = {_js(getattr(m, name))};" for name in (*NUMBER_NAMES, *CLOSE_NAMES)]
    lines += [_frozen_list("DEVICES", m.DEVICES), f"export const EVENT = Object.freeze({_js(m.EVENT)});"]
    return "\n".join(lines)


def _answers() -> str:
    """The kinds of questions, and the values that answer them."""
    kinds = f"/** @typedef {{{_literals(questionnaire.Kind)}}} QuestionKind */"
    return "\n".join([kinds, *(f"export const {name} = {_js(getattr(questionnaire, name))};" for name in ANSWER_NAMES)])


def _metrics() -> str:
    """The table of metrics, in the order of `METRICS`; what they are called is in the catalogue of texts."""
    rows = [
        {
            "key": metric.key,
            "symbol": metric.symbol,
            "unit": metric.unit,
            "low": metric.low,
            "high": metric.high,
            "digits": metric.digits,
            "optional": bool(metric.none_when),
        }
        for metric in METRICS
    ]
    keys = " | ".join(_js(metric.key) for metric in METRICS)
    table = "\n".join(f"  {_js(row)}," for row in rows)
    return f"""/** @typedef {{{keys}}} MetricKey */
/**
 * `low` and `high` bound the values, null where there is no bound; an `optional` metric may have no value.
 * @typedef {{{{
 *   key: MetricKey,
 *   symbol: string,
 *   unit: string,
 *   low: number | null,
 *   high: number | null,
 *   digits: number,
 *   optional: boolean
 * }}}} Metric
 */
export const NO_METRIC_VALUE = {_js(NO_VALUE)};
/** @type {{readonly Metric[]}} */
export const METRICS = Object.freeze([
{table}
]);"""


def _frozen_list(name: str, values: Iterable[str]) -> str:
    return f"export const {name} = Object.freeze(/** @type {{const}} */ ({_js(list(values))}));"


def _js(value: object) -> str:
    return msgspec.json.encode(value).decode()


# ---- binary frames ------------------------------------------------------------------------------------------


def _fixed_frame(frame: type[Packed]) -> str:
    """Type, encode and decode of a frame of fixed size."""
    name, layout, offsets = frame.__name__, frame.layout, frame.layout.offsets()
    writes = "\n".join(_write(field, offsets[field], wire) for field, wire in layout.fields.items())
    reads = "\n".join(f"    {_camel(field)}: {_read(offsets[field], wire)}," for field, wire in layout.fields.items())
    return f"""{frame_type(frame)}

/** @param {{{name}}} frame @returns {{ArrayBuffer}} */
export function encode{name}(frame) {{
  const view = new DataView(new ArrayBuffer({layout.size}));
  view.setUint8(0, {name.upper()});
{writes}
  return view.buffer;
}}

/** @param {{ArrayBuffer}} buffer @returns {{{name}}} */
export function decode{name}(buffer) {{
  const view = new DataView(buffer);
  if (view.byteLength !== {layout.size} || view.getUint8(0) !== {name.upper()}) throw new RangeError("not a {name}");
  return {{
{reads}
  }};
}}"""


def _bundle() -> str:
    head, pose, event = Bundle.layout, WirePose.layout, BundleEvent.layout
    offsets = head.offsets()
    counts = "\n".join(f"  const {_camel(name)} = view.getUint8({offsets[name]});" for name in head.counts)
    reads = "\n".join(f"    {_camel(name)}: {_read(offsets[name], wire)}," for name, wire in head.fields.items())
    return f"""{frame_type(BundleEvent)}

{frame_type(Bundle, _BUNDLE_PARTS)}

/** @param {{ArrayBuffer}} buffer @returns {{Bundle}} */
export function decodeBundle(buffer) {{
  const view = new DataView(buffer);
  if (view.byteLength < {head.size} || view.getUint8(0) !== BUNDLE) throw new RangeError("not a Bundle");
{counts}
  const firstEvent = {head.size} + poseCount * bodies * {pose.size};
  if (view.byteLength !== firstEvent + eventCount * {event.size}) throw new RangeError("a cut Bundle");
  const poses = new Float64Array(poseCount * bodies * {len(pose.fields)});
  for (let index = 0, at = {head.size}; at < firstEvent; index += {len(pose.fields)}, at += {pose.size}) {{
{_pose_reads(pose)}
  }}
  const events = [];
  for (let at = firstEvent; at < view.byteLength; at += {event.size}) {{
    events.push({{ {_event_reads(event)} }});
  }}
  return {{
{reads}
    bodies,
    poseCount,
    poses,
    events,
  }};
}}

/** Flag `i` is bit `i`. @param {{number}} bits @param {{number}} length @returns {{boolean[]}} */
function flagsOf(bits, length) {{
  return Array.from({{ length }}, (_, index) => ((bits >>> index) & 1) === 1);
}}"""


def _pose_reads(pose: FrameLayout) -> str:
    return "\n".join(
        f"    poses[index + {place}] = {_read(f'at + {offset}', wire)};"
        for place, (wire, offset) in enumerate(zip(pose.fields.values(), pose.offsets().values(), strict=True))
    )


def _event_reads(event: FrameLayout) -> str:
    offsets = event.offsets()
    return ", ".join(f"{_camel(name)}: {_read(f'at + {offsets[name]}', wire)}" for name, wire in event.fields.items())


_BUNDLE_PARTS = (
    "{number} bodies  two robots, then the items",
    "{number} poseCount  poses of each body",
    "{Float64Array} poses  poseCount x bodies x (x, y, angle)",
    "{BundleEvent[]} events",
)


def frame_type(frame: type[Packed], parts: Iterable[str] = ()) -> str:
    """The JSDoc type of a frame; `parts` follow the fields of its layout."""
    fields = [f"{{{TYPES[wire.form]}}} {_camel(name)}  {wire.meaning}" for name, wire in frame.layout.fields.items()]
    lines = [frame.__doc__ or "", f"@typedef {{object}} {frame.__name__}"]
    lines += [f"@property {each}" for each in (*fields, *parts)]
    return "/**\n" + "\n".join(f" * {line}" for line in lines) + "\n */"


def _write(name: str, offset: int, wire: Wire) -> str:
    assert wire.form is Form.ONE, f"the browser does not send fields such as {name}"
    value = f"frame.{_camel(name)}"
    scaled = f"Math.round({value} * {SCALE_NAMES[wire.scale]})" if wire.is_scaled else value
    return f"  view.set{ACCESSORS[wire.letter]}({offset}, {scaled}{_endianness(wire)});"


def _read(offset: int | str, wire: Wire) -> str:
    """An expression for a field that begins at `offset`."""
    value = f"view.get{ACCESSORS[wire.letter]}({offset}{_endianness(wire)})"
    scaled = f"{value} / {SCALE_NAMES[wire.scale]}" if wire.is_scaled else value
    match wire.form:
        case Form.ONE:
            return scaled
        case Form.FLAGS:
            return f"flagsOf({scaled}, bodies - 2)"
        case Form.EACH_SEAT:
            assert isinstance(offset, int)
            one = wire._replace(form=Form.ONE)
            return f"[{_read(offset, one)}, {_read(offset + SIZES[wire.letter], one)}]"


def _endianness(wire: Wire) -> str:
    return "" if SIZES[wire.letter] == 1 else ", true"


def _camel(name: str) -> str:
    return re.sub(r"_(\w)", lambda found: found[1].upper(), name)


# ---- control messages ---------------------------------------------------------------------------------------


def _control_types() -> str:
    """A JSDoc type per control message; what has a default may be left out by the client."""
    aliases = [f"/** @typedef {{{_literals(alias)}}} {name} */" for name, alias in _ALIASES.items()]
    parts = [_typedef(struct_type, optional=False) for struct_type in (m.SeatState, m.SeatGrant, m.FrameFields)]
    to_server, to_client = get_args(m.ClientMessage), get_args(m.ServerMessage)
    parts += [_typedef(struct_type, optional=True) for struct_type in to_server]
    parts += [_typedef(struct_type, optional=False) for struct_type in to_client]
    parts += [_union("ClientMessage", to_server), _union("ServerMessage", to_client)]
    return "\n".join(aliases) + "\n\n" + "\n\n".join(parts)


_ALIASES = {"Phase": m.Phase, "Mode": m.Mode, "Kind": m.Kind, "TutorialStep": m.TutorialStep}


def _typedef(struct_type: type[msgspec.Struct], optional: bool) -> str:
    config = struct_type.__struct_config__
    lines = [f"type: {_js(config.tag)}"] if config.tag else []
    for field in msgspec.structs.fields(struct_type):
        mark = "?" if optional and not field.required else ""
        lines.append(f"{field.name}{mark}: {_type(field.type)}")
    summary = (struct_type.__doc__ or "").strip().splitlines()[0]
    fields = ",\n *   ".join(lines)
    return f"/**\n * {summary}\n * @typedef {{{{\n *   {fields}\n * }}}} {struct_type.__name__}\n */"


def _union(name: str, members: tuple[type, ...]) -> str:
    return f"/** @typedef {{{' | '.join(member.__name__ for member in members)}}} {name} */"


def _literals(alias: object) -> str:
    return " | ".join(_js(value) for value in get_args(alias))


def _type(annotation: object) -> str:
    for name, alias in _ALIASES.items():
        if annotation is alias:
            return name
    origin = get_origin(annotation)
    if origin is Annotated:  # with what the server checks besides
        return _type(get_args(annotation)[0])
    if origin is list:
        (member,) = get_args(annotation)
        return f"{_type(member)}[]"
    if origin is dict:
        _, value = get_args(annotation)
        return f"Record<string, {_type(value)}>"
    if not isinstance(annotation, type):
        raise TypeError(f"no JavaScript type for {annotation}")
    return _SCALARS.get(annotation, annotation.__name__)


_SCALARS: dict[type, str] = {str: "string", int: "number", float: "number", bool: "boolean", object: "any"}


def main() -> None:
    TARGET.write_text(generate(), encoding="utf-8")


if __name__ == "__main__":
    main()
