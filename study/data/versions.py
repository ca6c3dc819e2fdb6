"""What a study was run with: its file, the software, the models, its own maps."""

import json
from functools import cache
from hashlib import sha256
from pathlib import Path

import movingout
from movingout.agents.around_others import acting_id
from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.agents.own_code import module_sha256
from movingout.maps import MapSpec, map_to_json
from movingout.recordings.versions import code_sha256, versions
from movingout.study.design.definition import Study
from movingout.study.design.review import agent_ids
from movingout.study.store.frozen_study import MAP

_PACKAGES = ("maps", "world", "recordings", "agents", "matches", "study", "server", "web")
_SUFFIXES = (".py", ".js", ".json", ".html", ".css", ".j2")


def code_versions() -> dict[str, str]:
    """Versions of this installation, the hash of its code that plays, and one over all of its source files."""
    return {**versions(), "movingout_code": code_sha256(), "source_sha256": _source_sha256()}


def model_hashes(study: Study) -> dict[str, str]:
    """SHA-256 of each trained agent's card (which names the hashes of its files) or file, "" for the others.

    With options, too, and inside another: `late:agent=dp@mine`. Maps of one's own are there as `map:NAME`, because
    their files may not change either.
    """
    agents = {agent_id: fingerprint(acting_id(agent_id)) for agent_id in agent_ids(study)}
    return agents | {f"{MAP}{name}": _map_sha256(study.load_map(name)) for name in study.own_maps}


def agent_code(study: Study) -> dict[str, str]:
    """SHA-256 of the source file of each agent that is somebody's own code, as `agent:ID`."""
    code = {agent_id: module_sha256(acting_id(agent_id)) for agent_id in agent_ids(study)}
    return {f"agent:{agent_id}": sha for agent_id, sha in code.items() if sha}


def _map_sha256(the_map: MapSpec) -> str:
    return sha256(json.dumps(map_to_json(the_map), sort_keys=True).encode()).hexdigest()


@cache
def _source_sha256() -> str:
    root = Path(str(movingout.__file__)).parent
    digest = sha256()
    for package in _PACKAGES:
        for path in sorted((root / package).rglob("*")):
            if path.suffix in _SUFFIXES and path.is_file():
                digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
