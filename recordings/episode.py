"""The values that make up an episode; how they are stored is up to `file_format`."""

import importlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np

from movingout.maps import MapSpec
from movingout.maps.render import SvgPicture
from movingout.world.scoring import delivered_items
from movingout.world.state import Floats, WorldState

SeatKind = Literal["human", "agent", "remote", "ghost", "idle"]
Source = Literal["live", "match", "scripted", "import", "tutorial"]  # tutorials are left out of every analysis
ActionSource = Literal["human", "agent", "remote", "ghost", "idle", "neutral"]  # neutral: nobody answered
Outcome = Literal["delivered", "time", "left", "stopped", "error", "interrupted"]
FINISHED: frozenset[Outcome] = frozenset({"delivered", "time"})  # of rounds that were played to their end, and count
EventKind = Literal[
    "start", "grab", "grab_failed", "release", "delivered", "undelivered", "collision",
    "pause", "resume", "drop", "return", "focus", "deadline_missed", "agent_error", "unseen_map", "tick_skipped",
    "tutorial_step", "tutorial_skipped", "ping", "pings_refused", "end",
]  # fmt: skip


_OPTIONS = re.compile(r":[^:]*=|(?<=^ghost):")  # where those of an agent's id begin; of a ghost, its recording


@dataclass(frozen=True, slots=True)
class SeatInfo:
    """Who sat in a seat: a pseudonym for people, the id for agents."""

    kind: SeatKind
    name: str
    checkpoint_sha256: str = ""
    device: str = ""  # keyboard, gamepad, touch; empty for agents


ROOM_PSEUDONYM = "person-"
"""How the name of a person without a study begins; it holds for one room, so one person may have several."""
_ROOM_PSEUDONYM = re.compile(rf"{ROOM_PSEUDONYM}(?:[a-km-np-z2-9]{{6}}|[0-9a-f]{{8}})")  # of a room; of its import


def is_room_pseudonym(name: str) -> bool:
    """Whether a room, or the import of its recording, made this name: elsewhere a person may be called `person-1`."""
    return _ROOM_PSEUDONYM.fullmatch(name) is not None


def is_person(kind: str) -> bool:
    """Whether a person played in a seat of that kind, then or in the recording that it replays."""
    return kind in ("human", "ghost")


def is_simulated(study: Mapping[str, str]) -> bool:
    """Whether what a recording keeps about its study says that the participants were programs (a rehearsal)."""
    return study.get("simulated") == "yes"


def player_label(kind: str, name: str, simulated: bool = False) -> str:
    """Who played in a seat: all people as one, agents by id without options, as `lab_agents:Driver`, ghosts as one.

    The participants of a rehearsal, `simulated`, do not pass for people.
    """
    if kind == "human":
        return "simulated people" if simulated else "people"
    return _OPTIONS.split(name or kind, maxsplit=1)[0]


@dataclass(frozen=True, slots=True)
class EpisodeHeader:
    """Everything known before the first tick; with the actions it determines the episode."""

    episode_id: str
    map: MapSpec
    seed: int
    limit_ticks: int
    seats: tuple[SeatInfo, SeatInfo]  # blue, red
    started_ns: int  # wall clock, ns since the epoch
    source: Source
    study: Mapping[str, str] = field(default_factory=dict)  # pseudonymous ids only

    @property
    def simulated(self) -> bool:
        """Whether the participants of its study were programs."""
        return is_simulated(self.study)


class InputSample(NamedTuple):
    """A raw input as it arrived from a client."""

    tick: int  # the tick that was being prepared
    seat: int
    seq: int
    client_ms: float
    move: float  # [-1, 1]
    heading: float  # [rad]
    grabs: int  # presses so far, modulo 256
    device: str
    rtt_ms: float
    connection: int = 0  # how often the seat had returned before; not stored, counted when a file is read


class TickRecord(NamedTuple):
    """One step: the actions that made it and the state after it."""

    actions: Floats  # (2, 3) exactly what World.step got
    sources: tuple[ActionSource, ActionSource]
    input_seqs: tuple[int, int]  # sequence number of the input used for this tick, -1 for none
    state: WorldState  # after the step; state.tick is this tick's number, from 1
    delivered: tuple[bool, ...]
    late_ms: float  # start of the tick after its due time
    slack_ms: tuple[float, float] = (-1.0, -1.0)  # how long before it was read each seat's input came, -1 unknown
    rtt_ms: tuple[float, float] = (-1.0, -1.0)  # round trip of each seat, -1 unknown


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened; -1 where seat or item do not apply."""

    tick: int
    kind: EventKind
    seat: int = -1
    item: int = -1
    detail: str = ""


@dataclass(frozen=True, slots=True)
class AgentDecision:
    """One answer of an agent seat."""

    tick: int
    seat: int
    latency_ms: float
    missed: bool
    detail: Mapping[str, object] = field(default_factory=dict)  # candidates, scores: flat JSON


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Episode:
    """A recording as read back; `ticks[k]` made `states[k + 1]`."""

    header: EpisodeHeader
    initial: WorldState
    ticks: tuple[TickRecord, ...]
    inputs: tuple[InputSample, ...]
    events: tuple[Event, ...]
    decisions: tuple[AgentDecision, ...]
    outcome: Outcome  # "interrupted" when it was never ended
    ended_ns: int  # wall clock, 0 when it was never ended
    complete: bool  # ended, and nothing is missing
    damage: str  # one sentence, empty for none
    versions: Mapping[str, str]  # of the software that recorded it
    attachments: Mapping[str, bytes]

    @property
    def actions(self) -> Floats:
        """(T, 2, 3) what the world was given."""
        return np.array([tick.actions for tick in self.ticks], dtype=np.float64).reshape(len(self.ticks), 2, 3)

    @property
    def states(self) -> tuple[WorldState, ...]:
        """T + 1 states, the first before any action."""
        return (self.initial, *(tick.state for tick in self.ticks))

    def delivered_after(self, tick: int) -> tuple[bool, ...]:
        """Of each item whether it is delivered after a tick; some may be at the start, 0."""
        if tick:
            return self.ticks[tick - 1].delivered
        return tuple(delivered_items(self.header.map, self.initial.item_poses).tolist())

    def __repr__(self) -> str:
        players = " and ".join(seat.name or seat.kind for seat in self.header.seats)
        return f"<Episode {self.header.episode_id}: {players}, {len(self.ticks)} ticks, {self.outcome}>"

    def plot(self) -> SvgPicture:
        """The way of everything over the map, and the metrics over time; notebooks show it, `.save(path)` keeps it."""
        drawn: SvgPicture = _notebook().episode_figure(self)
        return drawn

    def to_frame(self, layout: str = "") -> Any:
        """A pandas DataFrame with a row per state, the start first, and the columns of the exported table `ticks`.

        With the name of an observation layout also what each seat sees. MissingExtraError without pandas.
        """
        return _notebook().episode_frame(self, layout)


def _notebook() -> Any:
    """What draws and tabulates episodes needs this module, so it is imported on use."""
    return importlib.import_module("movingout.recordings.notebook")
