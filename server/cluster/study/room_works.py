"""What the node that runs a study has done with rooms at any node: functions that `node_calls` can send.

Each names the fencing token of the node that asks. A node that was stopped, and does not know yet that another one
runs the study, is refused by everybody who has heard of the other.
"""

from collections.abc import Callable
from typing import Any, Protocol

import msgspec

from movingout.maps import map_from_json
from movingout.maps.randomize import Split
from movingout.recordings.episode import Outcome
from movingout.server import messages as m
from movingout.server.notices import Notice
from movingout.server.public_host import Away, NoRoom
from movingout.server.rooms import registry, room_view
from movingout.server.rooms.registry import RoomRegistry
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_view import PlayedRound, RoomView
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig


class RoomsOfANode(Protocol):
    """What a node lets the one that runs the study do."""

    registry: RoomRegistry

    def obey(self, fence: int) -> None:
        """Raise Away unless this is the newest fencing token of the study that is known here."""

    async def open_kept(self, config: RoomConfig, seats: list[Seat]) -> Room:
        """Open a room and wait until a restart would bring it back. Raises MapError and AgentError."""

    def why_no_room(self) -> str:
        """Why no room can be opened here now, empty while one can."""

    def shards_here(self) -> list[str]: ...

    def is_gone(self, room_id: str) -> bool:
        """Whether a room that is not in the registry will not come back here."""

    def round_heard(self, room_id: str, played: PlayedRound) -> None: ...


class NodeStatus(msgspec.Struct):
    """One node, for the one that runs the study."""

    shards: list[str]  # whose rooms are there and tick
    refusal: str  # why no room can be opened there now, empty while one can
    rooms: int
    study_rooms: list[str]


class SeatPlan(msgspec.Struct):
    """A seat of a room that is to be opened; `key` is the hash of a token."""

    index: int
    kind: m.Kind
    agent_id: str = ""
    name: str = ""
    alias: str = ""
    key: bytes | None = None

    @staticmethod
    def of(seat: Seat) -> "SeatPlan":
        return SeatPlan(seat.index, seat.kind, seat.agent_id, seat.name, seat.alias, seat.key)

    def seat(self) -> Seat:
        return Seat(self.index, self.kind, self.agent_id, name=self.name, alias=self.alias, key=self.key)


def node_status(host: RoomsOfANode, fence: int) -> NodeStatus:
    host.obey(fence)
    rooms = registry.study_rooms(host.registry)
    return NodeStatus(host.shards_here(), host.why_no_room(), len(host.registry.rooms), rooms)


async def open_study_room(host: RoomsOfANode, fence: int, config: RoomConfig, seats: list[SeatPlan]) -> str:
    """Raises Away, MapError and AgentError."""
    host.obey(fence)
    if refusal := host.why_no_room():
        raise Away(refusal)
    return (await host.open_kept(config, [each.seat() for each in seats])).id


def close_study_room(
    host: RoomsOfANode, fence: int, room_id: str, code: int, notice: Notice, outcome: Outcome
) -> PlayedRound:
    """Raises Away and NoRoom."""
    host.obey(fence)
    return registry.close(host.registry, _room(host, room_id), code, notice, outcome)


def look_at(host: RoomsOfANode, fence: int, rooms: list[str]) -> dict[str, RoomView | None]:
    """Left out are rooms that are elsewhere, or still to come back here."""
    host.obey(fence)
    found = registry.views(host.registry, rooms)
    return {room_id: view for room_id, view in found.items() if view is not None or host.is_gone(room_id)}


def keep_map(
    host: RoomsOfANode, fence: int, designed: dict[str, Any], seed: int, split: Split, made: dict[str, Any]
) -> None:
    """A randomised map, made ahead."""
    host.obey(fence)
    host.registry.prepared_maps.keep((map_from_json(designed), seed, split), map_from_json(made))


def tell_round_over(host: RoomsOfANode, room_id: str, played: PlayedRound) -> None:
    """Told to the node that runs the study."""
    host.round_heard(room_id, played)


# ---- work on one room ---------------------------------------------------------------------------------------------


def ask_view(host: RoomsOfANode, fence: int, room_id: str) -> RoomView:
    return room_view.room_view(_asked(host, fence, room_id))


def ask_hold(host: RoomsOfANode, fence: int, room_id: str, notice: Notice) -> RoomView:
    return room_view.hold(_asked(host, fence, room_id), notice)


def ask_release(host: RoomsOfANode, fence: int, room_id: str) -> RoomView:
    return room_view.release(_asked(host, fence, room_id))


def ask_stopped_round(host: RoomsOfANode, fence: int, room_id: str) -> PlayedRound:
    return room_view.stopped_round(_asked(host, fence, room_id))


def ask_retire(host: RoomsOfANode, fence: int, room_id: str, seat: int) -> None:
    room_view.retire(_asked(host, fence, room_id), seat)


def ask_note_skip(host: RoomsOfANode, fence: int, room_id: str, seat: int) -> None:
    room_view.note_skip(_asked(host, fence, room_id), seat)


def ask_give_keys(host: RoomsOfANode, fence: int, room_id: str, keys: dict[int, bytes]) -> RoomView:
    return room_view.give_keys(_asked(host, fence, room_id), keys)


ROOM_WORKS: dict[Callable[..., Any], Callable[..., Any]] = {
    room_view.room_view: ask_view,
    room_view.hold: ask_hold,
    room_view.release: ask_release,
    room_view.stopped_round: ask_stopped_round,
    room_view.retire: ask_retire,
    room_view.note_skip: ask_note_skip,
    room_view.give_keys: ask_give_keys,
}
WORKS: tuple[Callable[..., Any], ...] = (
    node_status, open_study_room, close_study_room, look_at, keep_map, tell_round_over, *ROOM_WORKS.values(),
)  # fmt: skip


def _asked(host: RoomsOfANode, fence: int, room_id: str) -> Room:
    host.obey(fence)
    return _room(host, room_id)


def _room(host: RoomsOfANode, room_id: str) -> Room:
    """Raises NoRoom where it is gone for good, Away where it is elsewhere."""
    room = host.registry.rooms.get(room_id)
    if room is None and host.is_gone(room_id):
        raise NoRoom(f"there is no room {room_id}")
    if room is None:
        raise Away(f"the room {room_id} is at another node")
    return room
