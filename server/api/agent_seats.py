"""Which agents somebody may seat in a new room: so that a few visitors do not take the time of everybody's agents."""

from collections.abc import Collection

from movingout.server.agent_workers.capacity import BESIDE_STUDY, ONE_ADDRESS
from movingout.server.api.errors import ApiError
from movingout.server.public_host import NoRoom, PublicHost
from movingout.server.rooms.room import Room

NO_COST = ("", "idle")


async def admit_agents(host: PublicHost, kinds: Collection[str], agents: Collection[str], address: str) -> None:
    """Raises ApiError unless somebody at `address` (empty: the operator) may seat these agents beside each other.

    `kinds` are those of both seats. Whoever serves only this machine is the operator at every address.
    """
    stranger = bool(address) and not host.settings.private
    if stranger and set(kinds) <= {"agent", "ghost"}:
        text = "On this server a person sits in one of the seats; the operator may let agents play alone."
        raise ApiError(403, "agents_only", text)
    wanted = [agent for agent in agents if agent not in NO_COST]
    if not wanted or not (stranger or not host.settings.lobby):
        return
    taken = await _agents_of(host, address) if stranger else []
    use = await host.agent_use(wanted, taken)
    if taken and use.taken + use.wanted > ONE_ADDRESS * use.capacity:
        text = "Many agents play with people at your address already; try again when one of these games is over."
        raise ApiError(429, "too_many_agents", text)
    if not host.settings.lobby and use.used + use.wanted > BESIDE_STUDY * use.capacity:
        # what the operator tries beside a running study may not take the agents from its participants
        text = "The agents are kept for the participants of the study; try again when fewer rounds are played."
        raise ApiError(503, "no_agent", text)


async def _agents_of(host: PublicHost, address: str) -> list[str]:
    """The agents that play in the rooms of an address."""
    found = []
    for room_id in host.admission.rooms_of(address):
        try:
            found += await host.ask(room_id, _agents_in)
        except NoRoom:
            continue
    return found


def _agents_in(room: Room) -> list[str]:
    return [seat.agent_id for seat in room.seats if seat.kind == "agent" and seat.agent_id not in NO_COST]
