"""The option `--population` of `movingout demos`: which players it names."""

from collections.abc import Sequence
from pathlib import Path

from movingout.agents.catalogue import load_agent
from movingout.agents.data.demonstrations import Player
from movingout.agents.errors import AgentError, DataError
from movingout.agents.partners.families import ALL, FAMILY, families, group, installed_families, is_group, to_try
from movingout.agents.scripted.populations import POPULATIONS, population
from movingout.maps.files.list_file import LIST
from movingout.maps.suggestion import known_names

GROUPS_HELP = "a family as family:greedy, families, families:without-greedy, or @FILE (agent ids, one per line)"


def players_of(who: str) -> Sequence[Player]:
    """The players that `--population` names. Raises DataError for an unknown name."""
    if who in POPULATIONS:
        return population(who)
    if not is_group(who):
        known = [*POPULATIONS, *(FAMILY + name for name in (*families(), *installed_families())), ALL, "@FILE"]
        raise DataError(f"unknown population {who!r}; {known_names(who, known)}")
    try:
        for agent_id in to_try(who):  # fail now rather than in some episode
            load_agent(agent_id)
        return group(who)
    except AgentError as error:
        raise DataError(f"--population: {error}") from error


def short_name(who: str) -> str:
    """`--population` as the names of files begin with it."""
    return Path(who.removeprefix(LIST)).stem if who.startswith(LIST) else who.replace(":", "-")
