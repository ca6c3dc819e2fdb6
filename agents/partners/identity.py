"""Who an agent id is about: the agent inside another one, and the person."""

from movingout.agents.agent_options import parse_options
from movingout.agents.built_in import AROUND_OTHERS, USUAL_INSIDE
from movingout.agents.data.dataset import person
from movingout.agents.errors import AgentError


def inner_id(agent_id: str) -> str:
    """The id of the agent that `late:agent=…` or `clone:policy=…` is made around; empty for any other agent.

    Empty too where it is not named: what was recorded of such agents does not have the usual one either.
    """
    outer, _, options = agent_id.strip().partition(":")
    if outer not in AROUND_OTHERS:
        return ""
    return unfolded(str(parse_options(agent_id, options).get(AROUND_OTHERS[outer], "")))


def acting_id(agent_id: str) -> str:
    """The id of the agent that decides: the innermost one, the usual one where none is named, or the agent itself."""
    while inside := inner_id(agent_id) or USUAL_INSIDE.get(agent_id.strip().partition(":")[0], ""):
        agent_id = inside
    return agent_id


def person_behind(name: str) -> str:
    """The person or the agent that a name in an episode is about, late hands and noise taken off."""
    try:
        return person(inner_id(name) or name)
    except AgentError:  # people may have any name
        return person(name)


def unfolded(agent_id: str) -> str:
    """An id inside another one, as it is written alone."""
    return agent_id.replace(";", ",")
