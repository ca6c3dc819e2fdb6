"""One match and its result as values. Knows nothing of how a match is played."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import lru_cache
from numbers import Integral
from typing import Any, Literal

from movingout.maps import MapSpec, load_map
from movingout.maps.library import is_generated_or_shipped
from movingout.maps.randomize import Split, randomize
from movingout.matches.errors import MatchError
from movingout.world.constants import LIMIT_TICKS, MAX_SEED, MAX_TICKS
from movingout.world.metrics import Metrics

Challenge = Literal[1, 2]
_LATER = ("play_hash", "own_metrics", "code", "official_ac", "counts")  # fields that earlier versions did not write
Ending = Literal["delivered", "time", "failed"]
MAX_EPISODES = 1_000_000


@dataclass(frozen=True, slots=True)
class Match:
    """Everything that determines a match; equal matches have equal results."""

    map: str  # a name, or a path
    blue: str  # agent ids
    red: str
    seed: int
    challenge: Challenge = 1  # 2: items of other sizes and shapes, drawn by the seed
    ticks: int = LIMIT_TICKS
    split: Split = "evaluation"  # of Challenge 2: which combinations of size and shape items may have

    @property
    def id(self) -> str:
        """16 hexadecimal digits, the same on every machine."""
        text = json.dumps(asdict(self), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @property
    def seats(self) -> tuple[str, str]:
        return self.blue, self.red

    def world_map(self) -> MapSpec:
        """The map as played. Raises MapError when there is no such map or variant."""
        return _world_map(_designed(self.map), self.seed if self.challenge == 2 else None, self.split)


def check_numbers(episodes: object, seed: object, ticks: object, challenge: object) -> None:
    """Raises MatchError for numbers of a series of matches that cannot be, saying which can."""
    asked: tuple[tuple[str, object, int, int], ...] = (
        ("episodes", episodes, 1, MAX_EPISODES),
        ("seed", seed, 0, MAX_SEED),
        ("ticks", ticks, 1, MAX_TICKS),
        ("challenge", challenge, 1, 2),
    )
    for name, value, least, most in asked:
        if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
            raise MatchError(f"{name} is a whole number from {least} to {most}, not {value!r}")


def _designed(name: str) -> MapSpec:
    """The map of a name. A file is read each time: it may have changed since the last match."""
    return _unchanging(name) if is_generated_or_shipped(name) else load_map(name)


_unchanging = lru_cache(maxsize=64)(load_map)


@lru_cache(maxsize=64)
def _world_map(designed: MapSpec, seed: int | None, split: Split) -> MapSpec:
    return designed if seed is None else randomize(designed, seed, split)


@dataclass(frozen=True, slots=True)
class MatchResult:
    """The result of a match. A failed one counts as nothing delivered and nothing moved, and has the reason."""

    match: Match
    ending: Ending
    ticks: int
    delivered: int
    items: int
    metrics: Metrics  # of a failed match: TCR and NFD 0, the others None
    waiting_share: float | None  # of the ticks, as the official code counts; None for a failed match
    failure: str = ""  # one sentence
    failed_seat: int = -1  # 0 blue, 1 red, -1 neither
    recording: str = field(default="", compare=False)
    cpu_s: float = field(default=0.0, compare=False)  # processor time of the match, for estimates
    play_hash: str = field(
        default="", compare=False
    )  # of map, actions and end; "" if unknown: it never began, or is old
    own_metrics: Mapping[str, float | None] = field(
        default_factory=dict, compare=False
    )  # of installed packages, by key
    code: str = field(default="", compare=False)  # hash of our code that plays, in a file; "" in files of before
    official_ac: float | None = field(
        default=None, compare=False
    )  # as the official code counts; None where nothing was carried together, of a failed match, in files of before
    counts: Mapping[str, int] = field(
        default_factory=dict, compare=False
    )  # by agents, such as `red_llm_questions` to a language model; empty of a failed match, in files of before

    def to_json(self) -> dict[str, Any]:
        """A flat JSON object; `result_from_json` reads it back."""
        document: dict[str, Any] = {"id": self.match.id, **asdict(self.match)}
        for entry in fields(self):
            if entry.name == "metrics":
                document |= self.metrics.values()
            elif entry.name != "match":
                document[entry.name] = getattr(self, entry.name)
        document |= {"own_metrics": dict(self.own_metrics), "counts": dict(self.counts)}
        return {**document, "limit_ticks": self.match.ticks}


def failed_result(
    match: Match, reason: str, *, seat: int = -1, tick: int = 0, recording: str = "", play_hash: str = ""
) -> MatchResult:
    """The result of a match that was not played to its end."""
    return MatchResult(
        match=match,
        ending="failed",
        ticks=tick,
        delivered=0,
        items=0,
        metrics=Metrics.of({"tcr": 0.0, "nfd": 0.0, "wt_s": None}),
        waiting_share=None,
        failure=reason,
        failed_seat=seat,
        recording=recording,
        play_hash=play_hash,
    )


def match_to_json(match: Match) -> dict[str, Any]:
    return asdict(match)


def match_from_json(document: dict[str, Any]) -> Match:
    return Match(**document)


def result_from_json(document: dict[str, Any]) -> MatchResult:
    """Raises MatchError when the object is not a result of this version."""
    try:
        names = [entry.name for entry in fields(Match)]
        match = Match(**{**{name: document[name] for name in names}, "ticks": document["limit_ticks"]})
        names = [entry.name for entry in fields(MatchResult) if entry.name not in ("match", "metrics", *_LATER)]
        rest = {name: document[name] for name in names} | {"metrics": Metrics.of(document)}
    except (KeyError, TypeError) as error:
        raise MatchError(f"a result lacks the field {error}; another version wrote it") from error
    if match.id != document.get("id"):
        raise MatchError(f"the result {document.get('id')} was edited by hand; delete its line")
    later = {name: document[name] for name in _LATER if name in document}
    return MatchResult(match=match, **later, **rest)
