"""The agents that the lobby offers, as `/api/agents` answers them."""

import contextlib
import time
from collections.abc import Callable
from typing import Any

import orjson

from movingout.agents.built_in import AgentCard
from movingout.agents.catalogue import ALONE_TCR, UNSEEN_TCR, agent_card, agent_cards
from movingout.agents.errors import CheckpointError
from movingout.server.api.proposed_partner import proposed_partner
from movingout.server.settings import Settings

KEPT_S = 2.0  # an agent that was trained meanwhile appears after this time


class OfferedAgents:
    """Reads the cards at most every two seconds, however many ask: it takes milliseconds of the ticks' time."""

    def __init__(self, settings: Settings, clock: Callable[[], float] = time.monotonic) -> None:
        self._settings = settings
        self._clock = clock
        self._document = b""
        self._made_at = 0.0

    def document(self) -> bytes:
        now = self._clock()
        if not self._document or now - self._made_at >= KEPT_S:
            self._document, self._made_at = orjson.dumps(self._offered()), now
        return self._document

    def _offered(self) -> dict[str, Any]:
        partner, cards = proposed_partner(self._settings), [card for card in agent_cards() if card.offered]
        if partner not in {card.id for card in cards}:  # the operator's own, or with options
            with contextlib.suppress(CheckpointError):  # damaged since the start: the others can be chosen
                cards.append(agent_card(partner))
        return {"agents": [_offer(card) for card in cards], "default": partner}


def _offer(card: AgentCard) -> dict[str, Any]:
    """What the lobby shows of an agent; scores that were not measured are null."""
    tcr = {"unseen": card.scores.get(UNSEEN_TCR), "alone": card.scores.get(ALONE_TCR)}
    return {
        "id": card.id,
        "name": card.name,
        "kind": card.kind,
        "description": card.description,
        "policy": card.policy,
        "population": card.population,
        "tcr": tcr,
    }
