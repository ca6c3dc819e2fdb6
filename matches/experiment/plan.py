"""From a grid to the matches to play: each entry says which condition and which agent a match counts for."""

from collections.abc import Iterator
from dataclasses import dataclass

from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.scripted.populations import population
from movingout.matches.experiment.grid import PEOPLE, Condition, Contestant, Grid
from movingout.matches.match import Challenge, Match


@dataclass(frozen=True, slots=True)
class Entry:
    """One cell's share in a match. Two entries may share a match, which is then played once."""

    condition: str
    agent: str  # as in the grid, or its label
    partner: str
    seat: int  # of the agent
    match: Match


def entries(grid: Grid) -> list[Entry]:
    """All entries, maps outermost so that neighbours share a map, in an order that only the grid decides."""
    return [
        Entry(condition.name, one.name, partner, seat, match)
        for challenge in grid.challenges
        for the_map in grid.map_list
        for condition in grid.all_conditions
        for one in condition.contestants
        for partner in condition.partners_of(one)
        for seat in _seats(grid, one.agent, partner)
        for match in _matches(grid, one.agent, partner, seat, the_map, challenge)
    ]


def matches_of(plan: list[Entry]) -> list[Match]:
    """Each match once, in order."""
    return list({entry.match: None for entry in plan})


def missing_agents(grid: Grid) -> list[str]:
    """One sentence per agent that cannot be loaded here, with what the grid says about getting it."""
    needs = {one.agent: one.needs for condition in grid.all_conditions for one in condition.contestants}
    sentences = []
    for agent_id in sorted(_agent_ids(grid)):
        try:
            load_agent(agent_id)
        except AgentError as error:
            hint = needs.get(agent_id, "")
            sentences.append(f"{agent_id}: {error}" + (f" (to get it: {hint})" if hint else ""))
    return sentences


def seated(agent_id: str, seed: int, other: bool = False) -> str:
    """Who sits down for `people:C` with a seed; the id itself for anybody else. `other`: not whom it meets."""
    if not agent_id.startswith(PEOPLE):
        return agent_id
    people = population(agent_id.removeprefix(PEOPLE))
    return people[(seed + other) % len(people)].agent_id


def _agent_ids(grid: Grid) -> set[str]:
    pairs = [(condition, one) for condition in grid.all_conditions for one in condition.contestants]
    ids = {agent_id for condition, one in pairs for agent_id in _ids_of(condition, one)}
    return {seated(agent_id, 0) for agent_id in ids}


def _ids_of(condition: Condition, one: Contestant) -> list[str]:
    return [one.agent, *condition.partners_of(one)]


def _seats(grid: Grid, agent: str, partner: str) -> tuple[int, ...]:
    if grid.seats == "both" and agent == partner:
        return (0,)  # the other way round is the same pair
    return {"both": (0, 1), "blue": (0,), "red": (1,)}[grid.seats]


def _matches(grid: Grid, agent: str, partner: str, seat: int, the_map: str, challenge: Challenge) -> Iterator[Match]:
    """One match per seed; with both seats, even seeds are played in blue and odd ones in red."""
    for seed in grid.seed_range:
        if grid.seats == "both" and agent != partner and seed % 2 != seat:
            continue
        pair = (seated(agent, seed), seated(partner, seed, other=agent == partner))
        blue, red = pair if seat == 0 else pair[::-1]
        yield Match(the_map, blue, red, seed, challenge, grid.ticks, grid.split)
