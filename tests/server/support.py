"""Small fakes for the server's tests: a listener, an agent source, the services of a room."""

import itertools
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from movingout.maps import MapError, MapSpec
from movingout.maps.randomize import Split
from movingout.recordings import EpisodeHeader, EpisodeWriter, RecordingError
from movingout.server import messages as m
from movingout.server.agent_workers.agent_seat import AgentAnswer
from movingout.server.connection import control_messages
from movingout.server.frame_layout import Form, Packed
from movingout.server.frames import Bundle, Input
from movingout.server.notices import Notice
from movingout.server.rooms.room import Room
from movingout.server.rooms.seat import AgentPlayer, Seat
from movingout.server.rooms.services import RoomConfig
from movingout.world.ping import HelpPing
from movingout.world.state import Floats, WorldState

TICK = 0.1


ZERO: dict[Form, Any] = {Form.ONE: 0, Form.EACH_SEAT: (0, 0), Form.FLAGS: ()}


def zeros(frame: type[Packed]) -> dict[str, Any]:
    """Every declared field of a frame as zero."""
    return {name: ZERO[wire.form] for name, wire in frame.layout.fields.items()}


def make_input(**fields: Any) -> Input:
    """Blue's first input, nothing pressed, but for `fields`."""
    return Input(**(zeros(Input) | {"seq": 1} | fields))


def make_bundle(**fields: Any) -> Bundle:
    """The first tick of a round in which nobody has done anything, but for `fields`."""
    return Bundle(**(zeros(Bundle) | {"tick": 1, "held": (-1, -1)} | fields))


class Ear:
    """A client that keeps what it hears."""

    def __init__(self) -> None:
        self.rtt_ms = -1.0
        self.told: list[m.ServerMessage] = []
        self.bundles: list[Bundle] = []
        self.beats = 0
        self.goodbye: tuple[int, Notice] | None = None
        self.tokens: list[str] = []
        self.seats: list[int] = []

    def tell(self, message: m.ServerMessage, text: str = "") -> None:
        self.told.append(message)
        if isinstance(message, m.Welcome):
            self.tokens = [grant.token for grant in message.seats]
            self.seats = [grant.seat for grant in message.seats]

    def show(self, tick: int, frame: bytes, now: float) -> None:
        self.bundles.append(Bundle.decode(frame))

    def beat(self, frame: bytes) -> None:
        self.beats += 1

    def acknowledge(self, tick: int, now: float) -> bool:
        return False

    def dismiss(self, code: int, notice: Notice) -> None:
        self.goodbye = (code, notice)

    def last(self, kind: type[m.ServerMessage]) -> m.ServerMessage:
        return next(message for message in reversed(self.told) if isinstance(message, kind))


class FakePlayer:
    """An agent that answers with `action`, or misses while `asleep`."""

    def __init__(self, action: Floats) -> None:
        self.ready = True
        self.failed = ""
        self.slow = False  # to decide
        self.unseen = ""
        self.action = action
        self.asleep = False
        self.problem = ""
        self.observed: list[tuple[int, float]] = []
        self.closed = False
        self.pings: tuple[HelpPing, ...] = ()  # shown with the newest state

    def observe(self, state: WorldState, tick: int, deadline: float, pings: tuple[HelpPing, ...] = ()) -> None:
        assert state.tick == tick
        self.observed.append((tick, deadline))
        self.pings = pings

    def answer(self, tick: int) -> AgentAnswer:
        assert self.observed[-1][0] == tick, "the agent is asked about the state that it acts on"
        problem, self.problem = self.problem, ""
        if self.asleep:
            return AgentAnswer(np.zeros(3), True, -1.0, problem=problem)
        return AgentAnswer(self.action, False, 1.5, {"score": 1.0}, problem)

    def close(self) -> None:
        self.closed = True


class FakeAgents:
    """Opens FakePlayers."""

    def __init__(self) -> None:
        self.players: list[FakePlayer] = []
        self.action = np.array([1.0, 0.0, 0.0])
        self.slow = False  # to load
        self.unseen = ""

    def open(self, agent_id: str, map: MapSpec, seat: int, seed: int, ticks: int) -> AgentPlayer:
        self.players.append(FakePlayer(self.action))
        self.players[-1].ready = not self.slow
        self.players[-1].unseen = self.unseen
        return self.players[-1]


@dataclass
class FakeServices:
    """Everything around a room, in memory; recordings go to `folder` when there is one."""

    folder: Path | None = None
    agents: FakeAgents = field(default_factory=FakeAgents)
    archived: list[Path] = field(default_factory=list)
    results: list[tuple[str, m.Result]] = field(default_factory=list)
    changes: int = 0
    maps_ready: bool | MapError = True
    numbers: "itertools.count[int]" = field(default_factory=itertools.count)

    def world_map(self, designed: MapSpec, seed: int | None, split: Split) -> MapSpec:
        return designed

    def map_is_ready(self, designed: MapSpec, seed: int | None, split: Split) -> bool:
        if isinstance(self.maps_ready, MapError):
            raise self.maps_ready
        return self.maps_ready

    def open_recording(self, header: EpisodeHeader, initial: WorldState) -> EpisodeWriter:
        if self.folder is None:
            raise RecordingError("there is no folder for recordings")
        return EpisodeWriter.create(self.folder, header, initial)

    def archive(self, journal: Path) -> None:
        self.archived.append(journal)

    def ended(self, room_id: str, episode_id: str, result: m.Result) -> None:
        self.results.append((episode_id, result))

    def new_id(self) -> str:
        return f"id{next(self.numbers):06d}"

    def new_episode_id(self, room_id: str) -> str:
        return self.new_id()

    def new_token(self) -> str:
        return f"token{next(self.numbers)}"

    def wall_ns(self) -> int:
        return 1_700_000_000_000_000_000

    def changed(self, room_id: str) -> None:
        self.changes += 1


class Table:
    """A room with its clients and a clock that only moves when told to."""

    def __init__(
        self, *maps: str, services: FakeServices | None = None, seats: list[Seat] | None = None, **config: Any
    ):
        self.services = services or FakeServices()
        self.now = 1000.0
        self.seats = seats or [Seat(0, "human", shared=True), Seat(1, "human", shared=True)]
        self.room = Room("room", RoomConfig(maps=maps or ("Simple",), **config), self.seats, self.services, self.now)
        self.seqs = itertools.count(1)

    @property
    def phase(self) -> str:
        return self.room.phase

    def join(self, **request: object) -> Ear:
        ear = Ear()
        self.room.join(ear, m.Join("room", **request), self.now)  # type: ignore[arg-type]
        return ear

    def pair(self) -> tuple[Ear, Ear]:
        return self.join(claim=1), self.join(claim=1)

    def say(self, ear: Ear, message: m.ClientMessage) -> None:
        control_messages.handle(self.room, ear, message, self.now)

    def push(self, ear: Ear, seat: int, move: float = 1.0, heading: float = 0.0, grabs: int = 0, seq: int = 0) -> None:
        frame = make_input(seat=seat, seq=seq or next(self.seqs), move=move, heading=heading, grabs=grabs)
        self.room.take_input(ear, frame, self.now)

    def step(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            self.now += TICK
            self.room.tick(self.now, self.now)

    def seconds(self, seconds: float) -> None:
        self.step(round(seconds / TICK))

    def play(self) -> tuple[Ear, Ear]:
        """Two people, ready, the countdown over and the first tick made."""
        blue, red = self.pair()
        self.ready(blue, red)
        return blue, red

    def ready(self, *ears: Ear) -> None:
        for ear in ears:
            for seat in ear.seats:
                self.say(ear, m.Ready(seat))
        for _ in range(100):
            if self.room.phase != "countdown":
                break
            self.step()
