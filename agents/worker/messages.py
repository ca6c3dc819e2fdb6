"""Messages between server and agent worker: length-prefixed msgpack frames over a local socket.

Both ends run the same code, so there is no version. The server's end is `server.agent_workers.process`.
"""

import struct
from collections.abc import Iterator, Mapping

import msgspec
import numpy as np

from movingout.agents.base import ActionChunk
from movingout.maps import MapSpec
from movingout.world.ping import HelpPing
from movingout.world.state import WorldState

_LENGTH = struct.Struct("<I")


class Open(msgspec.Struct, tag=True, array_like=True, frozen=True):
    """An episode starts for a seat, identified by `key` in later messages.

    An agent that `must_keep_up` is refused where it takes longer for a decision than a tick.
    """

    key: int
    agent_id: str
    map: MapSpec
    seat: int
    seed: int
    ticks: int
    must_keep_up: bool = True


class Observe(msgspec.Struct, tag=True, array_like=True, frozen=True):
    """A request to decide for `tick` before `deadline` (seconds of the monotonic clock)."""

    key: int
    tick: int
    deadline: float
    state_tick: int
    state: bytes  # float64: robot poses (2, 3), velocities (2, 3), held (2,), item poses (N, 3)
    pings: tuple[HelpPing, ...] = ()


class Close(msgspec.Struct, tag=True, array_like=True, frozen=True):
    """The episode is over; the agent may be reused."""

    key: int


class Opened(msgspec.Struct, tag=True, array_like=True, frozen=True):
    """The agent is loaded, warmed up and reset; `share` of a core that its decisions take, 0 when not measured."""

    key: int
    share: float = 0.0


class Answer(msgspec.Struct, tag=True, array_like=True, frozen=True):
    """The chunk for `tick`; `execute` of its rows are played before the next request."""

    key: int
    tick: int
    chunk: bytes  # float64 (H, 4)
    execute: int
    decision_ms: float  # of the processor, its part of a batch; waiting for a busy machine is no cost of the agent
    detail: dict[str, object]


class Skipped(msgspec.Struct, tag=True, array_like=True, frozen=True):
    """The deadline passed before the worker could start."""

    key: int
    tick: int


class Failed(msgspec.Struct, tag=True, array_like=True, frozen=True):
    """The agent raised, gave an invalid answer, or could not be made; `fatal` if asking again is pointless.

    `slow` if it was refused because it takes longer for a decision than a tick.
    """

    key: int
    tick: int
    reason: str
    fatal: bool
    slow: bool = False


ToWorker = Open | Observe | Close
FromWorker = Opened | Answer | Skipped | Failed

_encoder = msgspec.msgpack.Encoder()
_to_worker: msgspec.msgpack.Decoder[ToWorker] = msgspec.msgpack.Decoder(ToWorker)
_from_worker: msgspec.msgpack.Decoder[FromWorker] = msgspec.msgpack.Decoder(FromWorker)


def frame(message: msgspec.Struct) -> bytes:
    """A message as bytes for the socket."""
    body = _encoder.encode(message)
    return _LENGTH.pack(len(body)) + body


class FrameBuffer:
    """Splits received bytes into frame bodies."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Add `data`; yield every frame body that is now complete."""
        self._bytes += data
        while len(self._bytes) >= _LENGTH.size:
            (size,) = _LENGTH.unpack_from(self._bytes)
            if len(self._bytes) < _LENGTH.size + size:
                return
            body = bytes(self._bytes[_LENGTH.size : _LENGTH.size + size])
            del self._bytes[: _LENGTH.size + size]
            yield body


def read_to_worker(body: bytes) -> ToWorker:
    """Decode a frame body at the worker's end."""
    return _to_worker.decode(body)


def read_from_worker(body: bytes) -> FromWorker:
    """Decode a frame body at the server's end."""
    return _from_worker.decode(body)


def observe_message(
    key: int, tick: int, deadline: float, state: WorldState, pings: tuple[HelpPing, ...] = ()
) -> Observe:
    """Pack a state and the pings that are shown."""
    values = np.concatenate(
        [state.robot_poses.ravel(), state.robot_velocities.ravel(), state.held, state.item_poses.ravel()]
    )
    return Observe(key, tick, deadline, state.tick, values.astype(np.float64).tobytes(), pings)


def observed_state(message: Observe) -> WorldState:
    """Unpack a state."""
    values = np.frombuffer(message.state, dtype=np.float64)
    return WorldState(
        tick=message.state_tick,
        robot_poses=values[0:6].reshape(2, 3),
        robot_velocities=values[6:12].reshape(2, 3),
        held=values[12:14].astype(np.int64),
        item_poses=values[14:].reshape(-1, 3),
    )


def answer_message(
    key: int, tick: int, chunk: ActionChunk, execute: int, decision_ms: float, detail: Mapping[str, object]
) -> Answer:
    """Pack a chunk."""
    return Answer(
        key, tick, np.ascontiguousarray(chunk, dtype=np.float64).tobytes(), execute, decision_ms, dict(detail)
    )


def answered_chunk(message: Answer) -> ActionChunk:
    """Unpack a chunk (H, 4)."""
    return np.frombuffer(message.chunk, dtype=np.float64).reshape(-1, 4)
