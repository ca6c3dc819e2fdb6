"""What the results of a grid depend on beside its own text, by SHA-256: weights, code, maps, lists, groups, metrics."""

import hashlib
import json
from dataclasses import dataclass, field

from movingout.agents.around_others import acting_id
from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.agents.own_code import code_fingerprint, source_sha256
from movingout.agents.partners.families import group, is_group, is_own
from movingout.maps import load_map, map_to_json
from movingout.maps.files.list_file import LIST
from movingout.maps.library import is_generated_or_shipped
from movingout.maps.selection import selected_maps
from movingout.matches.experiment.grid import Grid
from movingout.matches.experiment.plan import agent_names, planned_matches
from movingout.world.own_metrics import own_metrics


@dataclass(frozen=True, slots=True)
class Provenance:
    """Hashes by the id of the agent, the map's name or the metric's key; what comes with the project has none."""

    checkpoints: dict[str, str]
    code: dict[str, str]  # of one's own agents: the file that defines them, not what it imports
    maps: dict[str, str]  # of one's own map files: what they say, not how it is written
    lists: dict[str, str] = field(default_factory=dict)  # of lists (@FILE) and families of packages: whom they name
    groups: dict[str, str] = field(default_factory=dict)  # of our populations and families: who of them is here
    metrics: dict[str, str] = field(default_factory=dict)  # of installed packages: the file that computes them


def provenance_of(grid: Grid) -> Provenance:
    """What a grid would be played with now. Raises MovingOutError for an agent or a map that cannot be loaded."""
    matches = [entry.match for entry in planned_matches(grid)]
    seated = {agent_id for match in matches for agent_id in match.seats}
    agents = sorted({acting_id(agent_id) for agent_id in seated})
    own_maps = [name for name in sorted({match.map for match in matches}) if not is_generated_or_shipped(name)]
    return Provenance(
        checkpoints={agent_id: sha for agent_id in agents if (sha := fingerprint(agent_id))},
        code={agent_id: sha for agent_id in agents if (sha := code_fingerprint(agent_id))},
        maps={name: _map_fingerprint(name) for name in own_maps},
        metrics={metric.key: sha for metric in own_metrics() if (sha := source_sha256(metric.compute))},
        **named_by(grid),
    )


def named_by(grid: Grid) -> dict[str, dict[str, str]]:
    """Whom and what the lists and the groups of a grid name now: the matches of a grid depend on it."""
    words = [grid.maps] if isinstance(grid.maps, str) else grid.maps
    maps = {word: _fingerprint(selected_maps(word)) for word in words if word.startswith(LIST)}
    names = sorted(name for name in agent_names(grid) if is_group(name))
    members = {name: _fingerprint([partner.agent_id for partner in group(name)]) for name in names}
    return {
        "lists": maps | {name: sha for name, sha in members.items() if is_own(name)},
        "groups": {name: sha for name, sha in members.items() if not is_own(name)},
    }


def _map_fingerprint(name: str) -> str:
    return _fingerprint(map_to_json(load_map(name)))


def _fingerprint(said: object) -> str:
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()
