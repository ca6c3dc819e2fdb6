"""Partners made around another agent: `late:agent=…` and `clone:policy=…`. Options inside are joined by semicolons."""

from movingout.agents.agent_options import parse_options
from movingout.agents.base import Agent
from movingout.agents.catalogue import AROUND_OTHERS, load_agent
from movingout.agents.errors import AgentError
from movingout.agents.partners.late_hands import LateHands

CLONE_JITTER = 0.05  # rad
CLONE_SLIPS = 0.01  # per tick


def late(
    agent: str = "greedy", seed: int = 0, delay: int = 3, jitter: float = 0.15, slips: float = 0.0, keys: bool = False
) -> LateHands:
    """Any agent with late and jittery hands. Raises AgentError for an agent or an option that cannot be."""
    return LateHands(_inner(agent, "late"), seed=seed, delay=delay, jitter=jitter, slips=slips, keys=keys)


def clone(
    policy: str = "dp@all", seed: int = 0, delay: int = 0, jitter: float = CLONE_JITTER, slips: float = CLONE_SLIPS
) -> LateHands:
    """A trained policy with noise and delay of its own: a learned imitation of somebody.

    Policies of other seeds and ages are trained by `agents.curriculum.partners`. Raises AgentError.
    """
    if "@" not in str(policy):
        raise AgentError(f"clone: policy is the id of a trained agent, such as dp@all, not {policy!r}")
    return LateHands(_inner(policy, "clone"), seed=seed, delay=delay, jitter=jitter, slips=slips)


def inner_id(agent_id: str) -> str:
    """The id of the agent that `late:agent=…` or `clone:policy=…` is made around; empty for any other agent."""
    outer, _, options = agent_id.strip().partition(":")
    if outer not in AROUND_OTHERS:
        return ""
    return _unfolded(str(parse_options(agent_id, options).get(AROUND_OTHERS[outer], "")))


def _unfolded(agent_id: str) -> str:
    return agent_id.replace(";", ",")


def _inner(agent_id: str, outer: str) -> Agent:
    text = _unfolded(str(agent_id))
    if text.partition(":")[0] in AROUND_OTHERS:
        raise AgentError(f"{outer}: {agent_id!r} has late hands already; give its options to {outer}")
    return load_agent(text)
