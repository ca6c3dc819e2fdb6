"""The names of generated maps, `generated:awareness:1234`, and which of their seeds are for what."""

import re
from collections.abc import Mapping
from typing import Literal, get_args

from movingout.maps.errors import MapError
from movingout.maps.spec import Mode
from movingout.maps.suggestion import known_names

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


def generated_name(mode: Mode, seed: int) -> str:
    return f"{PREFIX}:{MODE_WORDS[mode]}:{seed}"


def is_generated(name: str) -> bool:
    """Whether a name begins like that of a generated map; it may still be faulty."""
    return name.partition(":")[0] == PREFIX


def read_name(name: str) -> tuple[Mode, int]:
    """Mode and seed of a name without a symmetry. Raises MapError with what would be a name."""
    parts = name.split(":")
    words = {word: mode for mode, word in MODE_WORDS.items()}
    if len(parts) != 3 or parts[0] != PREFIX:
        raise MapError(f"{name!r} is no generated map; write generated:MODE:SEED, for example generated:awareness:12")
    if parts[1] not in words:
        raise MapError(f"unknown mode {parts[1]!r} in {name}; {known_names(parts[1], words)}")
    if not _SEED.fullmatch(parts[2]):
        raise MapError(f"the seed in {name} is a whole number from 0 to {MOST_SEED}")
    return words[parts[1]], int(parts[2])


def split_of(seed: int) -> Split:
    """Which split a seed belongs to."""
    return next(split for split, seeds in SPLITS.items() if seed in seeds)
