"""The code of agents of one's own, by its hash: results of other code are not comparable."""

import hashlib
import inspect
from pathlib import Path

from movingout.agents.catalogue import factory_of

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
