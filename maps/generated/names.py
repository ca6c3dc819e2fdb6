"""Names of generated maps, `generated:awareness:12` or `generated:awareness:12:hard`, and what their seeds are for."""

import re
from collections.abc import Iterable, Mapping
from typing import Literal, NamedTuple, get_args

from movingout.maps.errors import MapError
from movingout.maps.spec import Mode
from movingout.maps.suggestion import counted, known_names

PREFIX = "generated"
Difficulty = Literal["easy", "medium", "hard"]
DIFFICULTIES: tuple[Difficulty, ...] = get_args(Difficulty)
MODE_WORDS: Mapping[Mode, str] = {
    "coordination": "coordination",
    "awareness": "awareness",
    "action consistency": "consistency",
}
"""How each mode is called in a name."""

Split = Literal["test", "validation", "training"]
SPLITS: Mapping[Split, range] = {
    "test": range(0, 10_000),
    "validation": range(10_000, 20_000),
    "training": range(20_000, 1_000_000),
}
"""The seeds of each split. What is measured is measured on `test`; nothing is ever trained or chosen on it."""

MOST_SEED = SPLITS["training"].stop - 1
_SEED = re.compile(r"0|[1-9]\d{0,5}")


class GeneratedName(NamedTuple):
    """What a name says."""

    mode: Mode
    seed: int
    difficulty: Difficulty | None = None  # None: that of the seed


def usual_difficulty(seed: int) -> Difficulty:
    """That of a seed for which none is named: easy, medium and hard in turn."""
    return DIFFICULTIES[seed % len(DIFFICULTIES)]


def generated_name(mode: Mode, seed: int, difficulty: Difficulty | None = None) -> str:
    """One name for each map: the difficulty is a part of it only where it is not that of the seed."""
    name = f"{PREFIX}:{MODE_WORDS[mode]}:{seed}"
    return name if difficulty in (None, usual_difficulty(seed)) else f"{name}:{difficulty}"


def is_generated(name: str) -> bool:
    """Whether a name begins like that of a generated map; it may still be faulty."""
    return name.partition(":")[0] == PREFIX


def read_name(name: str) -> GeneratedName:
    """What a name without a symmetry says. Raises MapError with what would be a name."""
    parts = name.split(":")
    words = {word: mode for mode, word in MODE_WORDS.items()}
    if parts[1:] and parts[1] in SPLITS:
        raise MapError(f"{name!r} names several maps; name one as generated:MODE:SEED, as in generated:awareness:12")
    if len(parts) not in (3, 4) or parts[0] != PREFIX:
        raise MapError(f"{name!r} is no generated map; write generated:MODE:SEED, for example generated:awareness:12")
    if parts[1] not in words:
        raise MapError(f"unknown mode {parts[1]!r} in {name}; {known_names(parts[1], words)}")
    if not _SEED.fullmatch(parts[2]):
        raise MapError(f"the seed in {name} is a whole number from 0 to {MOST_SEED}")
    mode, seed = words[parts[1]], int(parts[2])
    return GeneratedName(mode, seed, _difficulty(name, seed, parts[3]) if parts[3:] else None)


def _difficulty(name: str, seed: int, word: str) -> Difficulty:
    known = {str(one): one for one in DIFFICULTIES}
    if word not in known:
        raise MapError(f"unknown difficulty {word!r} in {name}; {known_names(word, known)}")
    if known[word] == usual_difficulty(seed):  # a second name of the same map would count as another map in tables
        raise MapError(f"{name} is {word} without saying so; write {name.removesuffix(':' + word)}")
    return known[word]


def split_of(seed: int) -> Split:
    """Which split a seed belongs to."""
    return next(split for split, seeds in SPLITS.items() if seed in seeds)


def test_maps_caution(names: Iterable[str]) -> str:
    """A sentence for whoever trains on test maps, when some are among these maps, or `generated:test`; else empty."""
    among = sorted({name for name in names if is_generated(name) and _is_test(*name.split(":")[1:3])})
    if not among:
        return ""
    others = f" and {counted(len(among) - 1, 'other')}" if among[1:] else ""
    verb = "are" if others else "is"
    return f"{among[0]}{others} {verb} for tests: what is trained or chosen on test maps is measured too well on them"


def _is_test(word: str = "", seed: str = "") -> bool:
    """By what stands after `generated:`, which in the name of a map file can be nothing, or no number."""
    return int(seed) in SPLITS["test"] if _SEED.fullmatch(seed) else word == "test"
