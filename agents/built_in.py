"""The agents that come with the project and need no checkpoint: what people are told of each, and what makes it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType


@dataclass(frozen=True, slots=True)
class AgentCard:
    """What a person who chooses a partner should know."""

    id: str
    name: str
    kind: str  # scripted, idle, policy
    maps: str  # "all", or names joined by commas
    description: str
    scores: Mapping[str, float] = field(default_factory=dict)
    policy: str = ""  # of a trained agent: the kind of its policy, which is the base where kind is bass
    population: str = ""  # of a trained agent: whose play it was trained on
    layout: str = ""  # of a trained agent: the layout of observations that it sees
    offered: bool = True  # to people who choose a partner in the lobby; the others are for training and measuring


@dataclass(frozen=True, slots=True)
class BuiltIn:
    """An agent, and where it is made."""

    card: AgentCard
    factory: str  # "module:attribute", imported when asked for


TUTORIAL_PARTNER = "movingout.agents.scripted.patient_partner:PatientPartner"
"""Waits for the player in tutorials; never offered in a list, since it does nothing else."""

_AGENTS = (
    BuiltIn(
        AgentCard(
            "scripted",
            "Scripted",
            "scripted",
            "all",
            "A computer partner that fetches, passes on and helps with heavy items. "
            "Options: seed and the fields of its style.",
        ),
        "movingout.agents.scripted:ScriptedAgent",
    ),
    BuiltIn(
        AgentCard(
            "person",
            "Scripted person",
            "scripted",
            "all",
            "One of sixty scripted people with habits of their own. Options: name, A01 to C20, and habits to change.",
        ),
        "movingout.agents.scripted.human_model:HumanModel",
    ),
    BuiltIn(
        AgentCard(
            "greedy",
            "Greedy walker",
            "scripted",
            "all",
            "Carries whatever is nearest the shortest way home, without a plan. "
            "Options: order (near, far, light, heavy), patience, seed.",
            offered=False,
        ),
        "movingout.agents.partners.greedy_walker:GreedyWalker",
    ),
    BuiltIn(
        AgentCard(
            "porter",
            "Stubborn porter",
            "scripted",
            "all",
            "One item after the other in an order of its own, straight to a goal that it never changes. "
            "Options: patience, seed.",
            offered=False,
        ),
        "movingout.agents.partners.porter:StubbornPorter",
    ),
    BuiltIn(
        AgentCard(
            "novice",
            "Novice",
            "scripted",
            "all",
            "Lets go early, pulls elsewhere, presses twice, wanders off; learns within the episode. "
            "Options: learns_in, seed.",
            offered=False,
        ),
        "movingout.agents.partners.novice:Novice",
    ),
    BuiltIn(
        AgentCard(
            "late",
            "Late hands",
            "scripted",
            "all",
            "Another agent with late and jittery hands. Options: agent, delay, jitter, slips, keys, seed.",
            offered=False,
        ),
        "movingout.agents.partners.wrapped:late",
    ),
    BuiltIn(
        AgentCard(
            "clone",
            "Learned clone",
            "policy",
            "all",
            "A trained policy with noise and delay of its own. Options: policy, delay, jitter, slips, seed.",
            offered=False,
        ),
        "movingout.agents.partners.wrapped:clone",
    ),
    BuiltIn(
        AgentCard("idle", "Idle", "idle", "all", "Does nothing: the control condition."),
        "movingout.agents.baseline.idle:IdleAgent",
    ),
)
BUILT_IN: Mapping[str, BuiltIn] = MappingProxyType({agent.card.id: agent for agent in _AGENTS})
"""By id, in display order."""
AROUND_OTHERS = {"late": "agent", "clone": "policy"}  # agents around others, and the option that names the other
USUAL_INSIDE = {"late": "greedy", "clone": "dp@all"}  # the other one where the option is not given
