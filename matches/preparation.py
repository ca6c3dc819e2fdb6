"""What is checked and made before matches are played, so that none of them ends for something known before."""

import os
from collections.abc import Sequence
from pathlib import Path

from movingout.agents.llm.model_id import outrun_cautions
from movingout.agents.map_limits import check_map_seen
from movingout.maps import load_map
from movingout.maps.commands.map_cautions import map_cautions
from movingout.maps.library import is_generated_or_shipped
from movingout.matches.errors import MatchError
from movingout.matches.match import Match


def cautions(matches: Sequence[Match]) -> list[str]:
    """What is to be said of their maps, and of language models that they outrun."""
    seated = (agent_id for match in matches for agent_id in match.seats)
    return [*map_cautions(match.map for match in matches), *outrun_cautions(seated)]


def check_own_maps(matches: Sequence[Match]) -> None:
    """Raises AgentError for a map file with more than an agent sees, before anything is played on it."""
    seated_on = dict.fromkeys((agent_id, match.map) for match in matches for agent_id in match.seats)
    for agent_id, name in seated_on:
        if not is_generated_or_shipped(name):
            check_map_seen(agent_id, load_map(name), name)


def check_variants(matches: Sequence[Match]) -> None:
    """Raises MapError for a map without a playable variant for a seed, which would count as the agents' failure."""
    varied = {(match.map, match.seed, match.split): match for match in matches if match.challenge == 2}
    own = {name for name in {match.map for match in varied.values()} if not is_generated_or_shipped(name)}
    for match in varied.values():
        if match.map in own:  # others have one for each seed that was tried; to make one takes 10 ms
            match.world_map()


def make_folder(folder: Path) -> None:
    """Make a folder unless it exists. Raises MatchError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MatchError(f"cannot make the folder {folder}: {error.strerror or error}") from error


def worker_count(wanted: int | None, matches: int) -> int:
    """How many workers, 1 or more; by default one per processor core, never more than matches. Raises MatchError."""
    if wanted is not None and wanted < 1:
        raise MatchError(f"at least 1 worker is needed, not {wanted}")
    return max(1, min(wanted or os.cpu_count() or 1, matches))
