"""The binary frames: each is declared once, field by field, as it lies on the wire.

From a declaration follow the Python value, its bytes, and the reader and writer in `web/messages.js`. What comes from a
client is checked here once (length, type, finite numbers), so nothing behind it has to.
"""

import math
import struct
from functools import partial
from math import floor
from typing import Annotated, ClassVar, Self

import numpy as np

from movingout.server import messages as m
from movingout.server.frame_layout import Form, FrameError, Packed, Wire, flags_of
from movingout.world.state import Floats

U8, I8, U16, U32, F64 = (partial(Wire, letter) for letter in "BbHId")
POSITION = Wire("h", "in units of the world", m.POSITION_SCALE)
ANGLE = partial(Wire, "h", scale=m.ANGLE_SCALE, wraps=True)
SEATS = Form.EACH_SEAT


class WirePose(Packed, frozen=True):
    """Where one body is.

    Sent in bulk: see `encode_poses`.
    """

    x: Annotated[float, POSITION]
    y: Annotated[float, POSITION]
    angle: Annotated[float, ANGLE("[rad]")]


class BundleEvent(Packed, frozen=True):
    """Something that happened inside a tick."""

    code: Annotated[int, U8("what happened: a value of EVENT")]
    seat: Annotated[int, I8("-1 for none")]
    item: Annotated[int, I8("-1 for none")]
    pose: Annotated[int, U8("which pose of the tick (0-4) to show it with")]

    @property
    def kind(self) -> str:
        return m.EVENT_CODES[self.code]


class Bundle(Packed, frozen=True):
    """One tick for the client to play back: five poses of every body, and what happened."""

    TYPE: ClassVar[int | None] = m.BUNDLE
    COUNTS: ClassVar[dict[str, str]] = {
        "bodies": "two robots, then the items",
        "pose_count": "poses of each body",
        "event_count": "events",
    }

    flags: Annotated[int, U8("1: this tick is not recorded, 2: ticks were skipped before it")]
    epoch: Annotated[int, U16("number of the round, as in `round`, modulo 65536")]
    tick: Annotated[int, U32("number of the state after it, from 1 in each round")]
    time_ms: Annotated[float, F64("server time at which the tick starts [ms]")]
    seqs: Annotated[tuple[int, int], U32("newest input applied, 0 for none", form=SEATS)]
    slack_ms: Annotated[
        tuple[float, float], U16("how long before the tick that input came [ms]", scale=m.SLACK_SCALE, form=SEATS)
    ]
    held: Annotated[tuple[int, int], I8("item in the hand, -1 for none", form=SEATS)]
    delivered: Annotated[tuple[bool, ...], U32("one bit per item", form=Form.FLAGS)]
    poses: Floats  # (5, 2 + N, 3) x, y, angle
    events: tuple[BundleEvent, ...] = ()

    def encode(self) -> bytes:
        count, bodies, _ = self.poses.shape
        head = self.layout.pack(self, bodies, count, len(self.events))
        return head + encode_poses(self.poses) + b"".join([event.encode() for event in self.events])

    @classmethod
    def decode(cls, frame: bytes) -> Self:
        """Raises FrameError."""
        fields = cls.layout.unpack(frame)
        bodies, count, events = (fields.pop(name) for name in cls.COUNTS)
        first_pose, event_size = cls.layout.size, BundleEvent.layout.size
        first_event = first_pose + count * bodies * WirePose.layout.size
        if len(frame) != first_event + events * event_size:
            raise FrameError(f"a bundle of {bodies} bodies and {events} events does not have {len(frame)} bytes")
        fields["delivered"] = flags_of(fields["delivered"], bodies - 2)
        starts = range(first_event, len(frame), event_size)
        return cls(
            **fields,
            poses=decode_poses(frame[first_pose:first_event], count, bodies),
            events=tuple(BundleEvent.decode(frame[start : start + event_size]) for start in starts),
        )


class Beat(Packed, frozen=True):
    """Sent 50 ms after a bundle, so that TCP notices a lost packet sooner."""

    TYPE: ClassVar[int | None] = m.BEAT

    tick: Annotated[int, U32("of the bundle")]


class Input(Packed, frozen=True):
    """The state of one seat's controls."""

    TYPE: ClassVar[int | None] = m.INPUT

    seat: Annotated[int, U8("0 blue, 1 red")]
    seq: Annotated[int, U32("counts the inputs of this seat; older ones are ignored")]
    ack_tick: Annotated[int, U32("newest tick received: the acknowledgement")]
    seen_tick: Annotated[int, U32("newest tick shown")]
    move: Annotated[float, Wire("h", "speed, from -1 (backward) to 1 (forward)", m.AXIS_SCALE)]
    heading: Annotated[float, ANGLE("[rad], 0 is up, counter-clockwise")]
    grabs: Annotated[int, U8("presses of the grab button since `welcome`, modulo 256")]
    device: Annotated[int, U8("0: keyboard, 1: gamepad, 2: touch, 3: program")]
    client_ms: Annotated[float, F64("the client's clock [ms], only recorded")]

    @classmethod
    def decode(cls, frame: bytes) -> Self:
        """Raises FrameError."""
        decoded = super().decode(frame)
        if decoded.seat > 1 or decoded.device >= len(m.DEVICES) or not math.isfinite(decoded.client_ms):
            raise FrameError("an input names seat 0 or 1, a known device and a finite time")
        return decoded


class Ping(Packed, frozen=True):
    """The client asks for a sample of the server's clock."""

    TYPE: ClassVar[int | None] = m.PING

    client_ms: Annotated[float, F64("the client's clock [ms]")]

    @classmethod
    def decode(cls, frame: bytes) -> Self:
        """Raises FrameError."""
        decoded = super().decode(frame)
        if not math.isfinite(decoded.client_ms):
            raise FrameError("a ping carries a finite time")
        return decoded


class Pong(Packed, frozen=True):
    """The answer to a ping."""

    TYPE: ClassVar[int | None] = m.PONG

    client_ms: Annotated[float, F64("as in the ping")]
    server_ms: Annotated[float, F64("the server's clock [ms]")]


FRAMES: dict[str, type[Packed]] = {
    "bundle": Bundle, "pose": WirePose, "event": BundleEvent, "beat": Beat, "input": Input, "ping": Ping, "pong": Pong,
}  # fmt: skip
FRAME_FIELDS = {
    name: m.FrameFields(format=frame.layout.format, names=frame.layout.names()) for name, frame in FRAMES.items()
}
"""For the welcome: programs read and write frames by these names."""

ClientFrame = Input | Ping


def decode_client_frame(frame: bytes) -> ClientFrame:
    """What a client may send in binary; raises FrameError for everything else."""
    kind = frame[0] if frame else -1
    if kind == m.INPUT:
        return Input.decode(frame)
    if kind == m.PING:
        return Ping.decode(frame)
    raise FrameError(f"unknown binary frame {kind}; known: {m.INPUT} input, {m.PING} ping")


def encode_poses(poses: Floats) -> bytes:
    """Poses (..., 3) as int16 with the wire's scales: positions clipped, angles wrapped.

    Plain arithmetic on a list: for a hundred numbers a handful of numpy calls costs more in a server whose caches
    hold many rooms.
    """
    numbers: list[float] = poses.ravel().tolist()
    wire = [0] * len(numbers)
    wire[0::3] = [floor(x * m.POSITION_SCALE + 0.5) for x in numbers[0::3]]
    wire[1::3] = [floor(y * m.POSITION_SCALE + 0.5) for y in numbers[1::3]]
    wire[2::3] = [(floor(angle * m.ANGLE_SCALE + 32768.5) & 0xFFFF) - 32768 for angle in numbers[2::3]]
    try:
        return struct.pack(f"<{len(wire)}h", *wire)
    except struct.error:  # a position beyond the wire's range
        return struct.pack(f"<{len(wire)}h", *(min(32767, max(-32767, number)) for number in wire))


def decode_poses(raw: bytes, count: int, bodies: int) -> Floats:
    """(count, bodies, 3) float64."""
    poses: Floats = np.frombuffer(raw, dtype="<i2").reshape(count, bodies, 3) / _POSE_SCALE
    return poses


_POSE_SCALE = np.array([m.POSITION_SCALE, m.POSITION_SCALE, m.ANGLE_SCALE])
