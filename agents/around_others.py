"""The agent inside another one, by its id: `late:agent=…` and `clone:policy=…` are made around others."""

from movingout.agents.agent_options import written_options
from movingout.agents.built_in import AROUND_OTHERS, USUAL_INSIDE


def inner_id(agent_id: str) -> str:
    """The id of the agent that `late:agent=…` or `clone:policy=…` is made around; empty for any other agent.

    Empty too where it is not named: what was recorded of such agents does not have the usual one either.
    """
    outer, _, options = agent_id.strip().partition(":")
    if outer not in AROUND_OTHERS:
        return ""
    return unfolded(str(dict(written_options(agent_id, options)).get(AROUND_OTHERS[outer], "")))


def acting_id(agent_id: str) -> str:
    """The id of the agent that decides: the innermost one, the usual one where none is named, or the agent itself."""
    while inside := inner_id(agent_id) or USUAL_INSIDE.get(agent_id.strip().partition(":")[0], ""):
        agent_id = inside
    return agent_id


def unfolded(agent_id: str) -> str:
    """An id inside another one, as it is written alone."""
    return agent_id.replace(";", ",")
