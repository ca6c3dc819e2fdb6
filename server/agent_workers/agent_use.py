"""What agents take of the time that there is for them."""

from collections.abc import Collection
from typing import NamedTuple

from movingout.server.agent_workers.pool import AgentPool


class AgentUse(NamedTuple):
    """Shares of a core: of some agents that are wanted, of some that play, of all that play, and of all there is."""

    wanted: float
    taken: float
    used: float
    capacity: float


def agent_use(agents: AgentPool, wanted: Collection[str], taken: Collection[str]) -> AgentUse:
    """The same for one pool."""
    return AgentUse(
        wanted=sum(agents.costs.of(agent) for agent in wanted),
        taken=sum(agents.costs.of(agent) for agent in taken),
        used=sum(row["load"] for row in agents.report()),
        capacity=agents.capacity,
    )
