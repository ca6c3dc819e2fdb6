"""Opening a room on request of a page: maps, seats, and who may take them."""

from typing import Any, Literal

import msgspec

from movingout.agents.catalogue import agent_card, agent_cards, open_to_all
from movingout.agents.errors import AgentError, CheckpointError
from movingout.agents.live_options import check_live_agent
from movingout.agents.map_limits import check_map_seen
from movingout.maps import TUTORIAL, MapError, MapSpec, MovingOutError, is_shipped, map_to_json
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings import RecordingError
from movingout.recordings.recorded_seat import GHOST, is_ghost
from movingout.server.api.agent_seats import admit_agents
from movingout.server.api.authentication import limit_replays
from movingout.server.api.errors import ApiError, unreadable
from movingout.server.api.map_routes import playable
from movingout.server.api.named_maps import own_map, unknown_map
from movingout.server.api.proposed_partner import proposed_partners
from movingout.server.api.room_places import RoomPlaces
from movingout.server.connection.admission import address_group
from movingout.server.own_maps.workers import Busy
from movingout.server.public_host import Away, PublicHost
from movingout.server.rooms.ghost_partner import GhostError, GhostSeat, ghost_config
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.rooms.tutorial import partner_seat
from movingout.server.security.tokens import hash_token, new_token
from movingout.world.constants import LIMIT_TICKS, MAX_TICKS, TICK_SECONDS, TUTORIAL_TICKS

MAX_ROUNDS = 36
LONGEST_AGENT = 400  # letters of an id with its options, which everybody in the room gets to see
# Errors that another agent may avoid.
_CANNOT_PLAY = ("no_agent", "too_many_agents", "damaged_agent", "unknown_agent", "agent_map")


class SeatRequest(msgspec.Struct, forbid_unknown_fields=True):
    """Who is to take a seat."""

    kind: Literal["here", "link", "agent", "partner", "remote", "ghost"]  # partner: whom the server proposes
    agent: str = ""
    recording: str = ""  # of a ghost: the episode whose seat of this colour plays again

    def __post_init__(self) -> None:
        self.agent = self.agent.strip()  # an agent has one id: costs, spares and recordings go by it


class RoomRequest(msgspec.Struct, forbid_unknown_fields=True):
    """The body of POST /api/rooms."""

    maps: list[str] = []
    seats: list[SeatRequest] = []
    limit_ticks: int = LIMIT_TICKS
    practice: bool = False
    challenge2_seed: int | None = None
    tutorial: bool = False  # nothing else is needed: one player here, and the partner of the tutorial
    pings: bool = True
    map: dict[str, Any] | None = None  # a drawn map, as a JSON document: a room of this one map, with `maps` empty


async def open_room(host: PublicHost, wanted: RoomRequest, address: str) -> dict[str, Any]:
    """Open the room for somebody at `address` (empty: the operator) and return how to join it.

    Raises ApiError with what would be possible; `full` names the refusal and its values.
    """
    _check_numbers(wanted)
    _check_named(wanted.seats)
    await RoomPlaces(host).make_place(for_operator=not address)
    refusal = host.refusal(for_operator=not address)
    if refusal:
        raise ApiError(503, "full", refusal.message, refusal=refusal.code, **refusal.values)  # the page says which
    if wanted.tutorial:
        return await _open_tutorial(host, wanted, address)
    if all(seat.kind != "partner" for seat in wanted.seats):
        return await _open_seated(host, wanted, address)
    *better, last = proposed_partners(host.settings)
    for partner in better:
        try:
            return await _open_seated(host, _with_partner(wanted, partner), address)
        except ApiError as error:
            if error.code not in _CANNOT_PLAY:
                raise
    return await _open_seated(host, _with_partner(wanted, last), address)


def _check_numbers(wanted: RoomRequest) -> None:
    """Raises ApiError for more maps or seats than a room has, before any of them is made or looked for."""
    if len(wanted.maps) > MAX_ROUNDS:
        raise ApiError(422, "maps", f"a series has 1 to {MAX_ROUNDS} maps, not {len(wanted.maps)}", most=MAX_ROUNDS)
    if len(wanted.seats) > 2:
        raise ApiError(422, "seats", f"a room has two seats, blue and red, not {len(wanted.seats)}")


def _check_named(seats: list[SeatRequest]) -> None:
    """Raises ApiError where a seat names an agent or a recording that its kind would leave unread, or an endless id."""
    for seat in seats:
        if len(seat.agent) > LONGEST_AGENT:
            text = f"the id of an agent has up to {LONGEST_AGENT} letters with its options, not {len(seat.agent)}"
            raise ApiError(422, "agent_options", text, agent=f"{seat.agent[:40]}…")
        for kind, named in (("agent", seat.agent), ("ghost", seat.recording)):
            if named and seat.kind != kind:
                text = f"a seat of kind {seat.kind!r} takes no {named!r}; write kind {kind!r}, or leave it out"
                raise ApiError(422, "seat_kind", text)


def _with_partner(wanted: RoomRequest, partner: str) -> RoomRequest:
    """The request with an agent in each seat that is left to the server."""
    seats = [SeatRequest("agent", partner) if seat.kind == "partner" else seat for seat in wanted.seats]
    return msgspec.structs.replace(wanted, seats=seats)


async def _open_seated(host: PublicHost, wanted: RoomRequest, address: str) -> dict[str, Any]:
    kinds, agents = [seat.kind for seat in wanted.seats], [seat.agent for seat in wanted.seats if seat.kind == "agent"]
    await admit_agents(host, kinds, agents, address)
    ghosts = await _ghosts(host, wanted.seats, address)
    if ghosts and not wanted.maps:
        wanted.maps = [next(iter(ghosts.values())).map]
    own_maps = await _own_maps(host, wanted, ghosts, address)
    for name in wanted.maps:
        if not is_shipped(name) and name not in own_maps:
            raise unknown_map(host, name)
    config = _checked_config(wanted, own_maps, host.settings.countdown_s)
    tokens = [new_token() if seat.kind == "here" else None for seat in wanted.seats]
    try:
        config = ghost_config(config, [*ghosts.values()])
        seats = [_seat(host, index, seat, tokens[index], ghosts.get(index)) for index, seat in enumerate(wanted.seats)]
    except GhostError as error:
        raise ApiError(422, "ghost", str(error)) from None
    for seat in seats:
        if seat.kind == "agent":
            _check_maps_seen(seat.agent_id, own_maps)
    try:
        await _prepare_maps(host, config, address)
        return await _opened(host, config, seats, tokens, address)
    except Away:
        raise
    except MovingOutError as error:
        raise unreadable(error, 503, "no_agent") from None


async def _prepare_maps(host: PublicHost, config: RoomConfig, address: str) -> None:
    """Raises ApiError where the map of the first round has no variant, which another partner would not change."""
    try:
        await host.prepare_maps(config, address)
    except Busy as error:
        raise ApiError(503, "map_busy", str(error)) from None
    except MapError as error:
        raise ApiError(422, "map_variant", f"This map cannot be varied: {error}.", map=config.maps[0]) from None


async def _opened(
    host: PublicHost, config: RoomConfig, seats: list[Seat], tokens: list[str | None], address: str
) -> dict[str, Any]:
    """Open the room and count it for the address. Raises MapError and AgentError."""
    owner = host.admission.owner(address) if address else ""
    room_id = await host.open_room(msgspec.structs.replace(config, owner=owner), seats)
    host.admission.opened_room(owner, room_id)
    return _joining(room_id, tokens)


def _joining(room_id: str, tokens: list[str | None]) -> dict[str, Any]:
    return {
        "room": room_id,
        "tokens": tokens,
        "join_path": f"/play/{room_id}",
        "watch_path": f"/watch/{room_id}",
    }


async def _open_tutorial(host: PublicHost, wanted: RoomRequest, address: str) -> dict[str, Any]:
    """A room that plays the tutorial, for one or two players; the partner takes the seat of an agent."""
    requests = wanted.seats or [SeatRequest("here"), SeatRequest("agent")]
    kinds = {request.kind for request in requests}
    if wanted.maps or len(requests) != 2 or kinds == {"agent"} or kinds & {"ghost", "partner"}:
        raise ApiError(422, "tutorial", "a tutorial has its own map, and seats for one or two players")
    tokens = [new_token() if request.kind == "here" else None for request in requests]
    seats = [
        partner_seat(index) if request.kind == "agent" else _player_seat(index, request.kind, tokens[index])
        for index, request in enumerate(requests)
    ]
    config = RoomConfig(
        maps=(TUTORIAL,),
        limit_ticks=TUTORIAL_TICKS,
        practice=True,
        tutorial=True,
        countdown_s=host.settings.countdown_s,
    )
    try:
        return await _opened(host, config, seats, tokens, address)
    except Away:
        raise
    except MovingOutError as error:
        raise ApiError(503, "no_agent", str(error)) from None


async def _ghosts(host: PublicHost, seats: list[SeatRequest], address: str) -> dict[int, GhostSeat]:
    """The recorded seats among `seats`: from this server's recordings, or the partner that the operator named."""
    found, group = {}, address_group(address)
    try:
        for index, seat in enumerate(seats[:2]):
            if seat.kind == "ghost":
                if address:
                    limit_replays(host, address)
                path = await host.recording_service.path(seat.recording, address=group)
                found[index] = await host.recording_service.ghost_seat(f"{path}#{SEAT_COLOURS[index]}", group)
            elif seat.kind == "agent" and seat.agent == host.settings.partner and is_ghost(seat.agent):
                found[index] = await host.recording_service.ghost_seat(seat.agent.removeprefix(f"{GHOST}:"), group)
    except RecordingError as error:
        text = f"This recording cannot be played against: {error}."
        raise unreadable(error, 422, "ghost", text) from None
    return found


async def _own_maps(
    host: PublicHost, wanted: RoomRequest, ghosts: dict[int, GhostSeat], address: str
) -> dict[str, MapSpec]:
    """The wanted maps that are not shipped: drawn, generated, of the operator's folder as they are now, recorded.

    To generate one takes time, so the address has as many as it may check. Raises ApiError.
    """
    if wanted.map is not None:
        if address and not host.admission.may_check_map(address):
            raise ApiError(429, "map_busy", "Too many maps were checked for your address; wait a few seconds.")
        drawn = await playable(host, wanted.map, address)
        if wanted.maps:
            raise ApiError(422, "maps", "a drawn map is played alone; leave `maps` empty", most=MAX_ROUNDS)
        wanted.maps = [drawn.name]
        return {drawn.name: drawn}
    found = {}
    for name in dict.fromkeys(wanted.maps):
        if not is_shipped(name):
            if address and not host.admission.may_check_map(address):
                raise ApiError(429, "map_busy", "Too many maps were made for your address; wait a few seconds.")
            found[name] = await own_map(host, name, address)
    recorded = {ghost.map: ghost.own for ghost in ghosts.values()}
    return {name: spec for name, spec in {**found, **recorded}.items() if spec is not None}


def _checked_config(wanted: RoomRequest, own_maps: dict[str, MapSpec], countdown_s: float) -> RoomConfig:
    if not 1 <= len(wanted.maps) <= MAX_ROUNDS:
        raise ApiError(422, "maps", f"a series has 1 to {MAX_ROUNDS} maps, not {len(wanted.maps)}", most=MAX_ROUNDS)
    if len(wanted.seats) != 2:
        raise ApiError(422, "seats", f"a room has two seats, blue and red, not {len(wanted.seats)}")
    unlimited = wanted.practice and wanted.limit_ticks == 0
    if not unlimited and not 10 <= wanted.limit_ticks <= MAX_TICKS:
        text = f"a round lasts 10 to {MAX_TICKS} ticks of {TICK_SECONDS} s; practice has no limit, whatever is given"
        raise ApiError(422, "limit_ticks", text)
    if wanted.challenge2_seed is not None and not 0 <= wanted.challenge2_seed < 2**31:
        raise ApiError(422, "challenge2_seed", "a seed is a whole number from 0 to 2147483647")
    return RoomConfig(
        maps=tuple(wanted.maps),
        limit_ticks=wanted.limit_ticks,
        practice=wanted.practice,
        challenge2_seed=wanted.challenge2_seed,
        countdown_s=countdown_s,
        pings=wanted.pings,
        own_maps={name: map_to_json(spec) for name, spec in own_maps.items()},
    )


def _seat(host: PublicHost, index: int, wanted: SeatRequest, token: str | None, ghost: GhostSeat | None) -> Seat:
    if ghost is not None:
        return ghost.seat_at(index)
    if wanted.kind == "agent":
        agent_id = _checked_options(_checked_agent(host, wanted.agent))
        if agent_id == "idle":
            return Seat(index, "idle", name="idle")
        return Seat(index, "agent", agent_id, name=agent_id)
    return _player_seat(index, wanted.kind, token)


def _check_maps_seen(agent_id: str, own_maps: dict[str, MapSpec]) -> None:
    """Raises ApiError for a map of somebody's own that has more of something than the agent sees."""
    for name, spec in own_maps.items():
        try:
            check_map_seen(agent_id, spec, name)
        except AgentError as error:
            raise ApiError(422, "agent_map", str(error), agent=agent_id, map=name) from None


def _player_seat(index: int, kind: str, token: str | None) -> Seat:
    """The seat of a person or of a program of somebody's."""
    if kind == "remote":
        return Seat(index, "remote", shared=True)
    seat = Seat(index, "human", shared=kind == "link")
    seat.token = hash_token(token) if token else None
    return seat


def _checked_options(agent_id: str) -> str:
    """Raises ApiError now for options with which no round could begin."""
    try:
        check_live_agent(agent_id)
    except CheckpointError:  # damaged since it was listed, which its worker says with the file
        return agent_id
    except AgentError as error:
        raise ApiError(422, "agent_options", str(error), agent=agent_id) from None
    return agent_id


def _checked_agent(host: PublicHost, agent_id: str) -> str:
    """Only agents of the catalogue and the operator's own: any other id could import a module or read a file."""
    if agent_id == host.settings.partner or open_to_all(agent_id):
        return agent_id
    try:
        if "@" in agent_id.partition(":")[0]:
            agent_card(agent_id)
    except CheckpointError as error:  # it is there, but damaged
        raise ApiError(422, "damaged_agent", f"{agent_id} cannot play: {error}", agent=agent_id) from None
    except AgentError:
        pass
    known = [card.id for card in agent_cards()]
    raise ApiError(422, "unknown_agent", f"unknown agent {agent_id!r}; known: {', '.join(known)}", agent=agent_id)
