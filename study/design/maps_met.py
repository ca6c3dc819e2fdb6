"""On which maps each agent of a study is met, and whether it sees all of those of one's own."""

from collections import defaultdict
from collections.abc import Collection, Iterator

from movingout.agents.errors import AgentError
from movingout.agents.map_limits import check_map_seen
from movingout.study.design.definition import Study


def maps_met(study: Study) -> tuple[tuple[str, str], ...]:
    """Each agent with each map that it may play on, as the file names them: those of the data first, then practice."""
    return tuple(dict.fromkeys(_met(study)))


def unseen_maps(study: Study, agents: Collection[str]) -> Iterator[str]:
    """A sentence for each of these agents that sees too little of maps of one's own, on which it would stand still."""
    own = study.own_maps
    refused: dict[str, list[str]] = defaultdict(list)
    for agent, name in maps_met(study):
        if agent in agents and name in own:
            try:
                check_map_seen(agent, study.load_map(name), name)
            except AgentError as error:
                refused[agent].append(str(error))
    yield from map("; ".join, refused.values())


def _met(study: Study) -> Iterator[tuple[str, str]]:
    substitute = study.pairing.agent if study.group == 2 and study.pairing.otherwise == "agent" else ""
    for block in study.blocks:
        agents = [study.partner(name).agent for name in block.partners] or [substitute]
        yield from ((agent, name) for agent in agents for name in block.maps if agent)
    if study.practice and not study.practice.tutorial:
        agent = study.practice.agent if study.group == 1 else substitute
        yield from [(agent, study.practice.map)] if agent else []
