"""The code of agents and metrics of one's own, by its hash: results of other code are not comparable."""

import contextlib
import functools
import hashlib
import inspect
import os
import sys
from collections.abc import Callable
from pathlib import Path

from movingout.agents.adapters.policy_file import POLICY_FILES
from movingout.agents.catalogue import factory_of
from movingout.maps.extras import AGENTS, installed

_OURS = "movingout"


def code_fingerprint(agent_id: str) -> str:
    """The SHA-256 of the file that defines the factory of an agent; empty for agents that come with the project.

    What that file imports does not count. Empty, too, where there is no source to read. Raises AgentError for an id
    that is unknown or a module that cannot be imported.
    """
    factory = _code_of(factory_of(agent_id))
    if getattr(factory, "__module__", _OURS).partition(".")[0] == _OURS:
        return ""
    return source_sha256(factory)


def source_sha256(called: Callable[..., object]) -> str:
    """The SHA-256 of the file that defines a class, a function or the class of an object; empty where there is none."""
    try:
        source = inspect.getsourcefile(_code_of(called))
        return hashlib.sha256(Path(source).read_bytes()).hexdigest() if source else ""
    except (TypeError, OSError):
        return ""


def _code_of(called: Callable[..., object]) -> Callable[..., object]:
    """The function or class itself: within decorators, of a partial, or the class of an object that can be called."""
    with contextlib.suppress(ValueError):  # of an object that answers to every name there is no end of wrappers
        called = inspect.unwrap(called)
    if isinstance(called, functools.partial):
        return _code_of(called.func)
    return called if inspect.isclass(called) or inspect.isroutine(called) else type(called)


def module_sha256(agent_id: str) -> str:
    """The SHA-256 of the file of the module that an id names, found without being run; empty where there is none.

    For a process that is not to import what somebody else wrote. Empty, too, for agents that come with the project.
    """
    reference = agent_id.partition(":")[0]
    if entry := installed(AGENTS).get(reference):
        reference = entry.value.partition(":")[0]
    elif ":" not in agent_id or reference in POLICY_FILES or reference.partition(".")[0] == _OURS:
        return ""
    parts = reference.split(".")
    for place in (*sys.path, os.getcwd()):  # where Python looks, and where the catalogue does
        whole = Path(place, *parts)
        for source in (whole.with_name(f"{parts[-1]}.py"), whole / "__init__.py"):
            with contextlib.suppress(OSError, ValueError):
                return hashlib.sha256(source.read_bytes()).hexdigest()
    return ""
