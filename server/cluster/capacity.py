"""How many nodes a number of participants needs, reckoned from measured figures (figures.yaml)."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec
import yaml

from movingout.maps.files.input_file import read_input
from movingout.server.cluster.errors import ClusterError
from movingout.server.cluster.shards import SHARDS
from movingout.server.settings import Limits
from movingout.world.constants import TICK_SECONDS

FIGURES = Path(__file__).with_name("figures.yaml")
MOST_PARTICIPANTS = 1_000_000  # what was measured on one machine says nothing of more
Positive = Annotated[float, msgspec.Meta(gt=0.0, le=1e9)]  # no infinite one, and none that is no number
NotNegative = Annotated[float, msgspec.Meta(ge=0.0, le=1e9)]
MOST_NODES = len(SHARDS) * 3 // 4  # so that the shards of nodes that have ended find a place


class MeasuredFigure(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One measured number; `source` says how, on what and when."""

    value: Positive
    unit: str
    source: str


class FigurePerAgent(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A number for each kind of agent, by the beginning of its id."""

    value: dict[str, NotNegative]
    unit: str
    source: str


class Figures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the plan reckons with."""

    core_per_room: MeasuredFigure
    core_for_rooms: MeasuredFigure
    core_per_agent: FigurePerAgent
    core_per_other_agent: MeasuredFigure
    core_for_agents: MeasuredFigure
    agent_worker_mb: MeasuredFigure
    agent_mb: MeasuredFigure
    node_mb: MeasuredFigure
    room_mb: MeasuredFigure
    client_bytes_per_s: MeasuredFigure
    recorded_bytes_per_tick: MeasuredFigure

    def of_agent(self, agent_id: str) -> tuple[float, bool]:
        """The share of a core that a seat takes, and whether that was measured."""
        kind = agent_id.partition(":")[0].partition("@")[0]
        found = self.core_per_agent.value.get(kind)
        return (self.core_per_other_agent.value, False) if found is None else (found, True)


@dataclass(frozen=True)
class Plan:
    """What so many participants at the same time need. Cores are those of the nodes and their agent workers."""

    participants: int
    agent: str
    rooms: int
    nodes: int
    workers_per_node: int
    cores: int
    memory_gb: float  # of nodes with their rooms and agent workers
    network_mbit_s: float  # to the participants
    recorded_gb_per_hour: float  # while all of them play
    notes: tuple[str, ...]


def read_figures(path: Path) -> Figures:
    """Raises ClusterError."""
    try:
        return msgspec.convert(yaml.safe_load(read_input(path).decode()), Figures)
    except (OSError, UnicodeError, RecursionError, yaml.YAMLError, msgspec.ValidationError) as error:
        raise ClusterError(f"{path} has no figures for a plan: {str(error).splitlines()[0]}") from None


def plan(participants: int, agent: str, figures: Figures) -> Plan:
    """Each participant plays with an agent, or without one (empty) with another participant. Raises ClusterError."""
    if not 1 <= participants <= MOST_PARTICIPANTS:
        raise ClusterError(f"a plan is for 1 to {MOST_PARTICIPANTS:,} participants, not {participants}")
    rooms = participants if agent else math.ceil(participants / 2)
    per_node = min(int(figures.core_for_rooms.value / figures.core_per_room.value), Limits().rooms)
    if per_node < 1:
        raise ClusterError("by these figures a core has no room: core_per_room is more than core_for_rooms")
    nodes = math.ceil(rooms / per_node)
    share, measured = figures.of_agent(agent) if agent else (0.0, True)
    agents_per_node = math.ceil(rooms / nodes) * share
    workers = max(1, math.ceil(agents_per_node / figures.core_for_agents.value))
    cores = nodes + (math.ceil(nodes * agents_per_node / figures.core_for_agents.value) if share else 0)
    each_node_mb = figures.node_mb.value + workers * figures.agent_worker_mb.value
    each_room_mb = figures.room_mb.value + (figures.agent_mb.value if agent else 0.0)
    memory_mb = nodes * each_node_mb + rooms * each_room_mb
    ticks_per_hour = 3600.0 / TICK_SECONDS
    return Plan(
        participants=participants,
        agent=agent,
        rooms=rooms,
        nodes=nodes,
        workers_per_node=workers,
        cores=cores,
        memory_gb=round(memory_mb / 1e3, 1),
        network_mbit_s=round(participants * figures.client_bytes_per_s.value * 8 / 1e6, 1),
        recorded_gb_per_hour=round(rooms * ticks_per_hour * figures.recorded_bytes_per_tick.value / 1e9, 1),
        notes=tuple(_notes(nodes, agent, measured)),
    )


def _notes(nodes: int, agent: str, measured: bool) -> list[str]:
    notes = []
    if nodes > 1:
        notes.append("one node more lets the others take over the rooms of one that ends")
    if nodes > MOST_NODES:
        count = math.ceil(nodes / MOST_NODES)
        notes.append(
            f"a cluster has up to {MOST_NODES} nodes: these are {count} clusters, each under a name of its own"
        )
    if not measured:
        notes.append(f"{agent} was not measured: the share of a core is the one that a server assumes at first")
    return notes
