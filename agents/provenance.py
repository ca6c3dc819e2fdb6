"""What a recording says about the agents in it: their ids, and of trained ones the card and its hash."""

import hashlib

from agents.catalogue import agent_card
from agents.checkpoint import CARD, MODEL_ROOTS, find_checkpoint
from agents.errors import CheckpointError
from maps.spec import SEAT_COLOURS
from recordings import SeatInfo
from recordings.ghost import GHOST, ghost_name


def seat_info(agent_id: str) -> SeatInfo:
    """How an agent is named in a recording. Raises AgentError for an id that names nothing."""
    if agent_card(agent_id).kind == GHOST:
        return SeatInfo(GHOST, ghost_name(agent_id))
    return SeatInfo("agent", agent_id, fingerprint(agent_id))


def fingerprint(agent_id: str) -> str:
    """The SHA-256 of the checkpoint's card, and so of its weights; empty for an agent without one."""
    card = _card(agent_id)
    return hashlib.sha256(card).hexdigest() if card else ""


def cards(seats: tuple[SeatInfo, SeatInfo]) -> dict[str, bytes]:
    """The cards of the trained agents among the seats, as attachments `card-blue.json`, `card-red.json`."""
    agents = [_card(seat.name) if seat.kind == "agent" else b"" for seat in seats]
    return {f"card-{colour}.json": card for colour, card in zip(SEAT_COLOURS, agents, strict=True) if card}


def _card(agent_id: str) -> bytes:
    """The bytes of the checkpoint's card; none for an agent without one, or when it cannot be read any more."""
    reference = agent_id.partition(":")[0]
    if "@" not in reference:
        return b""
    try:
        return (find_checkpoint(reference, *MODEL_ROOTS).folder / CARD).read_bytes()
    except (CheckpointError, OSError):
        return b""
