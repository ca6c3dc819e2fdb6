"""The five binary frames as values, each with `encode` and `decode` side by side.

The layouts are the structs of `server.messages`; a frame's fields are in the order of its struct. What comes from
a client is checked here once (length, type, finite numbers), so nothing behind it has to.
"""

import math
import struct
from math import floor
from typing import Any, NamedTuple

import numpy as np

from movingout.maps.errors import MovingOutError
from movingout.server import messages as m
from movingout.world.state import Floats

MOST_POSITION = 32767 / m.POSITION_SCALE


class FrameError(MovingOutError):
    """A binary frame that no client of this protocol sends."""


class BundleEvent(NamedTuple):
    """Something that happened inside a tick; `pose` (0-4) says when to show it."""

    code: int  # index into EVENT_CODES
    seat: int
    item: int
    pose: int

    @property
    def kind(self) -> str:
        return m.EVENT_CODES[self.code]


class Bundle(NamedTuple):
    """One tick for the client to play back: five real poses of every body, and what happened."""

    flags: int
    epoch: int  # of the round
    tick: int  # number of the state after it, from 1
    time_ms: float  # server time at which the tick starts
    seqs: tuple[int, int]  # newest input applied, blue and red
    slack_ms: tuple[float, float]  # how long before the latch that input came
    held: tuple[int, int]
    delivered: tuple[bool, ...]  # (N,)
    poses: Floats  # (5, 2 + N, 3) x, y, angle
    events: tuple[BundleEvent, ...] = ()

    def encode(self) -> bytes:
        count, bodies, _ = self.poses.shape
        head = m.BUNDLE_HEAD.pack(
            m.BUNDLE, self.flags, self.epoch, self.tick, self.time_ms, *self.seqs,
            *map(_wire_slack, self.slack_ms), *self.held, _mask(self.delivered), bodies, count, len(self.events),
        )  # fmt: skip
        events = b"".join(m.BUNDLE_EVENT.pack(*event) for event in self.events)
        return head + encode_poses(self.poses) + events

    @classmethod
    def decode(cls, frame: bytes) -> "Bundle":
        if len(frame) < m.BUNDLE_HEAD.size or frame[0] != m.BUNDLE:
            raise FrameError(f"a bundle has at least {m.BUNDLE_HEAD.size} bytes and begins with {m.BUNDLE}")
        _, flags, epoch, tick, time_ms, *rest, mask, bodies, count, events = m.BUNDLE_HEAD.unpack_from(frame)
        seq_blue, seq_red, slack_blue, slack_red, held_blue, held_red = rest
        first_event = m.BUNDLE_HEAD.size + count * bodies * m.BUNDLE_POSE.size
        if len(frame) != first_event + events * m.BUNDLE_EVENT.size:
            raise FrameError(f"a bundle of {bodies} bodies and {events} events does not have {len(frame)} bytes")
        return cls(
            flags=flags,
            epoch=epoch,
            tick=tick,
            time_ms=time_ms,
            seqs=(seq_blue, seq_red),
            slack_ms=(slack_blue / m.SLACK_SCALE, slack_red / m.SLACK_SCALE),
            held=(held_blue, held_red),
            delivered=tuple(bool(mask >> item & 1) for item in range(bodies - 2)),
            poses=decode_poses(frame[m.BUNDLE_HEAD.size : first_event], count, bodies),
            events=tuple(BundleEvent(*event) for event in m.BUNDLE_EVENT.iter_unpack(frame[first_event:])),
        )


class Beat(NamedTuple):
    """Sent 50 ms after the bundle of `tick`, so that TCP notices a lost packet sooner."""

    tick: int

    def encode(self) -> bytes:
        return m.BEAT_FRAME.pack(m.BEAT, *self)

    @classmethod
    def decode(cls, frame: bytes) -> "Beat":
        return cls(*_unpack(m.BEAT_FRAME, m.BEAT, frame))


class Input(NamedTuple):
    """The level state of one seat's controls."""

    seat: int
    seq: int
    ack_tick: int  # newest bundle received
    seen_tick: int  # newest tick shown
    move: float  # [-1, 1]
    heading: float  # [rad] in [-pi, pi]
    grabs: int  # presses so far, modulo 256
    device: int  # index into DEVICES
    client_ms: float

    def encode(self) -> bytes:
        move, heading = _round(self.move * m.AXIS_SCALE), _wrap16(_round(self.heading * m.ANGLE_SCALE))
        return m.INPUT_FRAME.pack(
            m.INPUT, self.seat, self.seq, self.ack_tick, self.seen_tick, move, heading, self.grabs, self.device,
            self.client_ms,
        )  # fmt: skip

    @classmethod
    def decode(cls, frame: bytes) -> "Input":
        seat, seq, ack, seen, move, heading, grabs, device, client_ms = _unpack(m.INPUT_FRAME, m.INPUT, frame)
        if seat > 1 or device >= len(m.DEVICES) or not math.isfinite(client_ms):
            raise FrameError("an input names seat 0 or 1, a known device and a finite time")
        stick = max(-1.0, move / m.AXIS_SCALE)
        return cls(seat, seq, ack, seen, stick, heading / m.ANGLE_SCALE, grabs, device, client_ms)


class Ping(NamedTuple):
    """A clock sample asked for by the client."""

    client_ms: float

    def encode(self) -> bytes:
        return m.PING_FRAME.pack(m.PING, *self)

    @classmethod
    def decode(cls, frame: bytes) -> "Ping":
        (client_ms,) = _unpack(m.PING_FRAME, m.PING, frame)
        if not math.isfinite(client_ms):
            raise FrameError("a ping carries a finite time")
        return cls(client_ms)


class Pong(NamedTuple):
    """The answer to a ping."""

    client_ms: float
    server_ms: float

    def encode(self) -> bytes:
        return m.PONG_FRAME.pack(m.PONG, *self)

    @classmethod
    def decode(cls, frame: bytes) -> "Pong":
        return cls(*_unpack(m.PONG_FRAME, m.PONG, frame))


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


def _unpack(layout: struct.Struct, kind: int, frame: bytes) -> tuple[Any, ...]:
    if len(frame) != layout.size or frame[0] != kind:
        raise FrameError(f"a frame of type {kind} has {layout.size} bytes")
    return layout.unpack(frame)[1:]


def _wire_slack(slack_ms: float) -> int:
    return min(65535, round(slack_ms * m.SLACK_SCALE)) if slack_ms > 0.0 else 0


def _mask(flags: tuple[bool, ...]) -> int:
    return sum(1 << index for index, flag in enumerate(flags) if flag)


def _round(value: float) -> int:
    """Half up, as JavaScript's Math.round."""
    return math.floor(value + 0.5)


def _wrap16(value: int) -> int:
    return (value + 32768) % 65536 - 32768
