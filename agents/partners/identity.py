"""Who a name in an episode is about."""

from movingout.agents.around_others import inner_id
from movingout.agents.data.dataset import person
from movingout.agents.errors import AgentError


def person_behind(name: str) -> str:
    """The person or the agent that a name in an episode is about, late hands and noise taken off."""
    try:
        return person(inner_id(name) or name)
    except AgentError:  # people may have any name
        return person(name)
