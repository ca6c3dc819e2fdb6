"""Agents that take no seat for a while, because their own threads computed too much."""

import logging
from collections.abc import Callable

log = logging.getLogger(__name__)

STOPPED_S = 600.0


class StoppedAgents:
    """Asked before an agent takes a seat."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._until: dict[str, float] = {}  # by agent

    def stop(self, agent_id: str, reason: str) -> None:
        """Its threads have ended with their worker."""
        self._until[agent_id] = self._clock() + STOPPED_S
        log.error("%s takes no seat for %.0f minutes: %s", agent_id, STOPPED_S / 60.0, reason)

    def why(self, agent_id: str) -> str:
        """Why an agent may not play now, empty when it may."""
        if self._clock() >= self._until.get(agent_id, 0.0):
            return ""
        return "the agent's own threads computed too much a short while ago"
