"""The matches that a grid asks for, each with the condition and the agent that it counts for."""

from collections.abc import Iterator
from dataclasses import dataclass

from movingout.agents.base import Agent
from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.partners.families import group, member, to_try
from movingout.matches.experiment.grid import Grid
from movingout.matches.match import Challenge, Match


@dataclass(frozen=True, slots=True)
class PlannedMatch:
    """A match and the cell of the grid it counts for. A match that counts for two cells is played once."""

    condition: str
    agent: str  # as in the grid, or its label
    partner: str
    seat: int  # of the agent
    match: Match


ORDER = 2  # of the members of groups; in 1, with both seats, members of even groups kept to one seat


def planned_matches(grid: Grid, order: int = ORDER) -> list[PlannedMatch]:
    """All matches in an order that depends on the grid alone; maps are outermost, so that neighbours share a map.

    `order`: that of the folder, for one that was begun by an earlier version.
    """
    return [
        PlannedMatch(condition.name, one.name, partner, seat, match)
        for challenge in grid.challenges
        for the_map in grid.map_list
        for condition in grid.all_conditions
        for one in condition.contestants
        for partner in condition.partners_of(one)
        for seat in _seats(grid, one.agent, partner)
        for match in _matches(grid, order, one.agent, partner, seat, the_map, challenge)
    ]


def matches_of(plan: list[PlannedMatch]) -> list[Match]:
    """The distinct matches, in order."""
    return list({entry.match: None for entry in plan})


def missing_agents(grid: Grid) -> list[str]:
    """A sentence for each agent that cannot be loaded, with what the grid says about how to get it."""
    needs = {one.agent: one.needs for condition in grid.all_conditions for one in condition.contestants}
    sentences = []
    for agent_id in sorted(_agent_ids(grid)):
        try:
            load_for_workers(agent_id)
        except AgentError as error:
            hint = needs.get(agent_id, "")
            sentences.append(f"{agent_id}: {error}" + (f" (to get it: {hint})" if hint else ""))
    return sentences


def load_for_workers(agent_id: str) -> Agent:
    """An agent that worker processes can make, too. Raises AgentError."""
    if "__main__:" in agent_id:
        raise AgentError(
            "worker processes do not have what this script or notebook defines; give the class itself to play(), "
            "or put it into a file of its own"
        )
    return load_agent(agent_id)


def agent_for_seed(agent_id: str, seed: int, other: bool = False) -> str:
    """The agent of a seed: for `people:C` or `family:greedy` one of several, for any other id the id itself.

    With `other` it is the next one, for when both seats are of one group. Raises AgentError for an unknown group.
    """
    return member(agent_id, seed + other)


def agent_names(grid: Grid) -> set[str]:
    """All agents and groups of them that a grid names."""
    pairs = [(condition, one) for condition in grid.all_conditions for one in condition.contestants]
    return {name for condition, one in pairs for name in (one.agent, *condition.partners_of(one))}


def _agent_ids(grid: Grid) -> set[str]:
    return {one for name in agent_names(grid) for one in to_try(name)}


def _seats(grid: Grid, agent: str, partner: str) -> tuple[int, ...]:
    if grid.seats == "both" and agent == partner:
        return (0,)  # swapping the seats gives the same pair
    return {"both": (0, 1), "blue": (0,), "red": (1,)}[grid.seats]


def _matches(
    grid: Grid, order: int, agent: str, partner: str, seat: int, the_map: str, challenge: Challenge
) -> Iterator[Match]:
    """One match per seed; where the agent plays both seats, even seeds are in blue and odd ones in red."""
    own, others = group(agent), group(partner)
    for seed in grid.seed_range:
        if grid.seats == "both" and agent != partner and seed % 2 != seat:
            continue
        both = grid.seats == "both" and agent != partner and order > 1
        pair = (own[_turn(seed, len(own), both)], others[_turn(seed + (agent == partner), len(others), both)])
        blue, red = pair if seat == 0 else pair[::-1]
        yield Match(the_map, blue.agent_id, red.agent_id, seed, challenge, grid.ticks, grid.split)


def _turn(seed: int, members: int, both_seats: bool) -> int:
    """Whose turn it is in a group with this seed.

    Seats alternate with seeds, so in a group of even size everybody would be met in one seat only: each pass through it
    begins one member later than the last, and after two everybody was met in both.
    """
    late = seed // members if both_seats and members % 2 == 0 else 0
    return (seed + late) % members
