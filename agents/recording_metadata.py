"""What a recording stores about its agents: ids and, for trained agents, the card and its hash."""

from movingout.agents.catalogue import agent_card
from movingout.agents.checkpoint.checkpoint import card_bytes, fingerprint
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings import SeatInfo
from movingout.recordings.recorded_seat import GHOST, ghost_name


def seat_info(agent_id: str) -> SeatInfo:
    """How an agent is named in a recording. Raises AgentError for an unknown id."""
    if agent_card(agent_id).kind == GHOST:
        return SeatInfo(GHOST, ghost_name(agent_id))
    return SeatInfo("agent", agent_id, fingerprint(agent_id))


def cards(seats: tuple[SeatInfo, SeatInfo]) -> dict[str, bytes]:
    """The cards of the trained agents among the seats, as attachments `card-blue.json`, `card-red.json`."""
    agents = [card_bytes(seat.name) if seat.kind == "agent" else b"" for seat in seats]
    return {f"card-{colour}.json": card for colour, card in zip(SEAT_COLOURS, agents, strict=True) if card}
