"""What a client knows of its seat: binary frames of the server as observations, chunks of actions as frames for it."""

import math
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.agents.action_chunk import checked_chunk, world_action
from movingout.agents.base import EpisodeInfo, Observation
from movingout.agents.observation.seat_observation import observe
from movingout.maps import MapSpec, map_from_json
from movingout.world.constants import POSE_SECONDS
from movingout.world.ping import HelpPing, shown
from movingout.world.state import Floats, WorldState

POSITION, ANGLE, LEVEL = 20000, 32768 / math.pi, 32767  # scales of the binary frames
PROGRAM = 3  # the device of an input frame
INPUT = 3  # type of a frame


class RemoteSeat:
    """One seat over the rounds of a room; it knows no network."""

    def __init__(self, seat: int, frames: Mapping[str, Mapping[str, Any]]) -> None:
        """`frames`: the layouts of binary frames, as the server's welcome says them."""
        self.map: MapSpec | None = None
        self.limit_ticks = 0
        self.newest: Observation | None = None
        self._seat = seat
        self._frames = {name: (struct.Struct(one["format"]), one["names"]) for name, one in frames.items()}
        self._rows: Floats = np.empty((0, 4))
        self._seq = self._grabs = self._tick = self._epoch = 0
        self._pings: tuple[HelpPing, ...] = ()
        self._silent = False  # nothing was sent for the newest state

    @property
    def tick(self) -> int:
        """The newest tick that was received."""
        return self._tick

    def begin(self, message: Mapping[str, Any]) -> None:
        """A round is coming: the server's message of type `round`."""
        self.map, self.limit_ticks = map_from_json(message["map"]), message["limit_ticks"]
        self._epoch, self._pings = message["epoch"], ()

    def wait_for_round(self) -> None:
        """Forget what is left of the last round."""
        self.newest, self._rows = None, np.empty((0, 4))

    def episode(self, seed: int) -> EpisodeInfo:
        """What an agent is told before a round."""
        assert self.map is not None
        return EpisodeInfo(self.map, self._seat, seed, self.limit_ticks)

    def play(self, chunk: npt.ArrayLike) -> None:
        """Play a chunk (H, 4) from the next input on. Raises AgentError."""
        self._rows, self._silent = checked_chunk(chunk), False

    def take_ping(self, message: Mapping[str, Any]) -> None:
        """A seat asks for help: the server's message of type `ping`. Those of other rounds are passed over."""
        if message["epoch"] == self._epoch:
            self._pings = (*self._pings, HelpPing(*(message[name] for name in HelpPing._fields)))

    def take_bundle(self, frame: bytes) -> bool:
        """Note the state after a tick; whether an input is to be sent now. Bundles of other rounds are passed over."""
        head, names = self._frames["bundle"]
        fields = dict(zip(names, head.unpack_from(frame), strict=True))
        if self.map is None or fields["epoch"] != self._epoch % 65536:
            return False
        unanswered, self._silent = self._silent, True
        self._tick = fields["tick"]
        self._pings = shown(self._pings, self._tick)
        poses = _poses(self._frames["pose"][0], frame, head.size, fields)
        self.newest = observe(self.map, _state(fields, poses), self._seat, pings=self._pings)
        return bool(len(self._rows)) or unanswered  # the rest of the chunk; at its end, stand still

    def next_input(self) -> bytes:
        """The next row of the chunk as a frame; without one, stand still."""
        row, self._rows = (self._rows[0], self._rows[1:]) if len(self._rows) else (None, self._rows)
        distance, heading, toggle = (0.0, self._heading(), 0.0) if row is None else world_action(row)
        self._seq += 1
        self._grabs += int(toggle)
        layout, names = self._frames["input"]
        numbers = {
            **{"type": INPUT, "seat": self._seat, "seq": self._seq, "ack_tick": self._tick, "seen_tick": self._tick},
            **{"move": round(distance * LEVEL), "heading": _wrapped(heading), "grabs": self._grabs % 256},
            "device": PROGRAM,
        }
        return layout.pack(*(numbers.get(name, 0) for name in names))

    def _heading(self) -> float:
        return 0.0 if self.newest is None else float(self.newest.state.robot_poses[self._seat, 2])


def _poses(pose: struct.Struct, frame: bytes, start: int, fields: dict[str, Any]) -> Floats:
    """(P, bodies, 3) the poses of a bundle."""
    count = fields["pose_count"] * fields["bodies"]
    numbers = [pose.unpack_from(frame, start + index * pose.size) for index in range(count)]
    scaled = np.array(numbers, dtype=np.float64) / (POSITION, POSITION, ANGLE)
    return scaled.reshape(fields["pose_count"], fields["bodies"], 3)


def _state(fields: dict[str, Any], poses: Floats) -> WorldState:
    """The state after a bundle's last pose; velocities are those between its last two."""
    last, before = poses[-1, :2], poses[-2, :2] if len(poses) > 1 else poses[-1, :2]
    moved = last - before
    moved[:, 2] = (moved[:, 2] + np.pi) % (2 * np.pi) - np.pi
    held = np.array([fields["held_blue"], fields["held_red"]])
    return WorldState(fields["tick"], last, moved / POSE_SECONDS, held, poses[-1, 2:])


def _wrapped(heading: float) -> int:
    """As a frame has it: an int16, whose ends meet at half a turn."""
    return (round(math.remainder(heading, 2 * math.pi) * ANGLE) + 32768) % 65536 - 32768
