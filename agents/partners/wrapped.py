"""Partners made around another agent: `late:agent=…` and `clone:policy=…`. Options inside are joined by semicolons."""

from collections.abc import Mapping

from movingout.agents.agent_options import OptionValue
from movingout.agents.around_others import unfolded
from movingout.agents.base import Agent
from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.built_in import AROUND_OTHERS, USUAL_INSIDE
from movingout.agents.catalogue import load_admitted_agent
from movingout.agents.errors import AgentError
from movingout.agents.partners.late_hands import LateHands

CLONE_JITTER = 0.05  # rad
CLONE_SLIPS = 0.01  # per tick


def late(
    agent: str = USUAL_INSIDE["late"],
    seed: int = 0,
    delay: int = 3,
    jitter: float = 0.15,
    slips: float = 0.0,
    keys: bool = False,
) -> LateHands:
    """Any agent with late and jittery hands. Raises AgentError for an agent or an option that cannot be."""
    return LateHands(_inner(agent, "late"), seed=seed, delay=delay, jitter=jitter, slips=slips, keys=keys)


def clone(
    policy: str = USUAL_INSIDE["clone"],
    seed: int = 0,
    delay: int = 0,
    jitter: float = CLONE_JITTER,
    slips: float = CLONE_SLIPS,
) -> LateHands:
    """A trained policy with noise and delay of its own: a learned imitation of somebody.

    Policies of other seeds and ages are trained by `agents.curriculum.partners`. Raises AgentError.
    """
    return LateHands(_inner(policy, "clone"), seed=seed, delay=delay, jitter=jitter, slips=slips)


def checked_inner(outer: str, options: Mapping[str, OptionValue]) -> str:
    """The id of the agent inside, empty for the usual one, unloaded. Raises AgentError as `late` and `clone`."""
    others = {name: value for name, value in options.items() if name != AROUND_OTHERS[outer]}
    LateHands(IdleAgent(), **others)  # type: ignore[arg-type]  # it checks its values itself
    named = options.get(AROUND_OTHERS[outer])
    return "" if named is None else _inner_id(named, outer)


def _inner(agent_id: str, outer: str) -> Agent:
    return load_admitted_agent(_inner_id(agent_id, outer))


def _inner_id(agent_id: object, outer: str) -> str:
    if outer == "clone" and "@" not in str(agent_id):
        raise AgentError(f"clone: policy is the id of a trained agent, such as dp@all, not {agent_id!r}")
    text = unfolded(str(agent_id))
    if text.partition(":")[0] in AROUND_OTHERS:
        raise AgentError(f"{outer}: {agent_id!r} has late hands already; give its options to {outer}")
    return text
