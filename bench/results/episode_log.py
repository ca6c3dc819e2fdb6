"""Evaluation episodes: who plays with whom, the outcome, and the file that keeps finished ones."""

import contextlib
import hashlib
import importlib.metadata
import importlib.util
import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path

from movingout.agents.checkpoint.checkpoint import find_checkpoint, model_roots
from movingout.maps.errors import MovingOutError
from movingout.matches import Match
from movingout.matches.match import Challenge
from movingout.recordings.versions import code_sha256


@dataclass(frozen=True, slots=True)
class Run:
    """One episode: an agent in a seat of a map with a partner; in Challenge 2 on the held-out variant of the seed."""

    agent: str
    partner: str
    map: str
    seat: int
    seed: int
    ticks: int
    challenge: Challenge = 1

    @property
    def match(self) -> Match:
        """The match to play; seat 0 is blue."""
        blue, red = (self.agent, self.partner) if self.seat == 0 else (self.partner, self.agent)
        return Match(self.map, blue, red, self.seed, self.challenge, self.ticks)


@dataclass(frozen=True, slots=True)
class Outcome:
    """The metrics of an episode, and its CPU time."""

    run: Run
    tcr: float
    nfd: float
    wt_s: float
    ac: float | None
    cpu_s: float
    interdependence: float | None = None  # logs of earlier versions do not have it


class EpisodeLog:
    """A file of finished episodes. Each is valid as long as its agents, its map and the code that plays are unchanged.

    Several processes may append to one file. Incomplete lines, left by a kill or a full disk, are skipped.
    """

    def __init__(self, path: Path) -> None:
        """Read the file if it exists. Raises MovingOutError if it is not a log."""
        self._path = path
        self._known = _read(path) if path.exists() else {}

    def known(self, todo: Sequence[Run]) -> dict[Run, Outcome]:
        """Outcomes of the runs that have been played."""
        return {run: self._known[key] for run in todo if (key := _key(run)) in self._known}

    def append(self, outcome: Outcome) -> None:
        """Add the outcome of an episode."""
        key = _key(outcome.run)
        self._known[key] = outcome
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("ab+") as file:
            torn = file.seek(0, os.SEEK_END) > 0 and os.pread(file.fileno(), 1, file.tell() - 1) != b"\n"
            line = json.dumps({"key": key, "outcome": asdict(outcome)}) + "\n"
            file.write((b"\n" if torn else b"") + line.encode())


def _read(path: Path) -> dict[str, Outcome]:
    try:
        lines = path.read_bytes().splitlines()
    except OSError as error:
        raise MovingOutError(f"cannot read {path}: {error.strerror or error}") from error
    found = {}
    for line in lines:
        with contextlib.suppress(ValueError, TypeError, KeyError):
            entry = json.loads(line)
            found[entry["key"]] = Outcome(**{**entry["outcome"], "run": Run(**entry["outcome"]["run"])})
    if lines and not found:
        raise MovingOutError(f"{path} is not a log of finished episodes")
    return found


def _key(run: Run) -> str:
    versions = {"version": _version(run.agent), "partner_version": _version(run.partner), "code": code_sha256()}
    played_in = {"world": _hash(repr(run.match.world_map())), "pymunk": importlib.metadata.version("pymunk")}
    about = {name: value for name, value in asdict(run).items() if (name, value) != ("challenge", 1)}  # as ever
    return json.dumps({**about, **versions, **played_in}, sort_keys=True)


@lru_cache
def _version(agent_id: str) -> str:
    """A hash of what an agent has besides our code: its checkpoint, or the module it is loaded from."""
    reference = agent_id.partition(":")[0]
    if "@" in reference:
        card = find_checkpoint(reference, *model_roots()).card
        parts = (card.policy, card.selection, card.value, *card.files)
        described = {"inputs", "outputs"}  # on newer cards alone, and implied by the hash of the file
        return _hash("".join(part.model_dump_json(exclude=described) for part in parts if part))
    with contextlib.suppress(ImportError, ValueError):
        own = importlib.util.find_spec(reference)
        if own is not None and own.origin:
            return hashlib.sha256(Path(own.origin).read_bytes()).hexdigest()
    return ""


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
