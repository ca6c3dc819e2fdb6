"""The code of agents of one's own, by its hash: results of other code are not comparable."""

import hashlib
import inspect
import os
import sys
from importlib.machinery import PathFinder
from pathlib import Path

from movingout.agents.catalogue import factory_of
from movingout.maps.extras import AGENTS, installed

_OURS = "movingout"


def code_fingerprint(agent_id: str) -> str:
    """The SHA-256 of the file that defines the factory of an agent; empty for agents that come with the project.

    What that file imports does not count. Empty, too, where there is no source to read. Raises AgentError for an id
    that is unknown or a module that cannot be imported.
    """
    factory = factory_of(agent_id)
    if getattr(factory, "__module__", _OURS).partition(".")[0] == _OURS:
        return ""
    try:
        source = inspect.getsourcefile(inspect.unwrap(factory))
        return hashlib.sha256(Path(source).read_bytes()).hexdigest() if source else ""
    except (TypeError, OSError):
        return ""


def module_sha256(agent_id: str) -> str:
    """The SHA-256 of the file of the module that an id names, found without being run; empty where there is none.

    For a process that is not to import what somebody else wrote. Empty, too, for agents that come with the project.
    """
    reference = agent_id.partition(":")[0]
    if entry := installed(AGENTS).get(reference):
        reference = entry.value.partition(":")[0]
    elif ":" not in agent_id:
        return ""
    source = _source_of(reference)
    return hashlib.sha256(source.read_bytes()).hexdigest() if source else ""


def _source_of(module: str) -> Path | None:
    """The source file of `package.module`, looked for where Python would, and in the current folder."""
    places: list[str] | None = [*sys.path, os.getcwd()]
    origin: str | None = None
    name = ""
    for part in module.split("."):
        name = f"{name}.{part}" if name else part
        spec = PathFinder.find_spec(name, places)
        if spec is None or spec.name.partition(".")[0] == _OURS:
            return None
        origin, places = spec.origin, list(spec.submodule_search_locations or [])
    return Path(origin) if origin and Path(origin).is_file() else None
