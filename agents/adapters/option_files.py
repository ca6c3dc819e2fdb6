"""The files and folders that an agent's id names, such as weights or the recording of a ghost, by their hash."""

import hashlib
import os
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from movingout.agents.adapters.policy_file import POLICY_FILES
from movingout.agents.agent_options import parse_options
from movingout.agents.built_in import BUILT_IN
from movingout.agents.errors import AgentError
from movingout.agents.llm.model_id import LLM
from movingout.recordings.recorded_seat import GHOST

_BLOCK = 1 << 20
_COMPILED = "__pycache__"  # Python writes it when a module is imported


def file_fingerprint(agent_id: str) -> str:
    """The SHA-256 of the file, or of all files of the folder with their names, that an id or its options name.

    Of several, that of their hashes; empty where there is none. Agents that come with the project take no files.
    """
    hashes = [_fingerprint(path) for path in _named_paths(agent_id)]
    return hashes[0] if len(hashes) == 1 else hashlib.sha256(" ".join(hashes).encode()).hexdigest() if hashes else ""


def _named_paths(agent_id: str) -> Iterator[Path]:
    """Those that exist, in the order of the options."""
    head, _, rest = agent_id.strip().partition(":")
    if head == GHOST:
        recording = Path(rest.rpartition("#")[0])
        yield from [recording] if recording.is_file() else []
        return
    if head in BUILT_IN or head == LLM or "@" in head:
        return
    first, _, behind = rest.partition(":")
    try:
        options = parse_options(agent_id, rest if head in POLICY_FILES or "=" in first else behind)
    except AgentError:  # it is refused when it is loaded; a recorded seat has no options
        return
    for value in options.values():
        path = os.path.expanduser(str(value))  # of a number, too: a number is written as it was
        is_folder = isinstance(value, str) and os.path.isdir(path) and not _grows(path)
        if not isinstance(value, bool) and (os.path.isfile(path) or is_folder):
            yield Path(path)


def _grows(folder: str) -> bool:
    """Whether it is or holds the working folder, where results are written; else it would never stay the same."""
    whole = os.path.realpath(folder)
    return os.path.commonpath([whole, os.getcwd()]) == whole


def _fingerprint(path: Path) -> str:
    whole = [path] if path.is_file() else sorted(one for one in path.rglob("*") if one.is_file())
    files = [one for one in whole if _COMPILED not in one.parts]
    return _sha256(str(path), tuple((str(one), one.stat().st_size, one.stat().st_mtime_ns) for one in files))


@lru_cache(maxsize=32)
def _sha256(root: str, facts: tuple[tuple[str, int, int], ...]) -> str:
    """Computed once for files of the same sizes and times."""
    whole = hashlib.sha256()
    for name, _, _ in facts:
        if name != root:
            whole.update(str(Path(name).relative_to(root)).encode() + b"\0")
        with open(name, "rb") as file:
            while block := file.read(_BLOCK):
                whole.update(block)
    return whole.hexdigest()
