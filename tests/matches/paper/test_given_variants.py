"""Nobody is evaluated on items that were learned from, whoever recorded the episodes."""

from pathlib import Path

import pytest

from movingout.maps import load_map
from movingout.maps.randomize import EVALUATION_PAIRS, Split, pairs_of, randomize
from movingout.matches.errors import MatchError
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.data_sets import list_episodes
from movingout.matches.paper.given_variants import fair_variants
from movingout.matches.paper.workspace import Workspace
from tests.agents.learning import recorded

MAP = load_map("HandOff")


def _variants(folder: Path, split: Split, count: int = 6) -> list[Path]:
    return [
        recorded(folder, f"{split}{seed}", 9, the_map=randomize(MAP, seed, split), people=(f"a{seed}", f"b{seed}"))
        for seed in range(count)
    ]


def _pairs(seed: int, split: Split) -> set[tuple[str, str]]:
    return {(item.size, item.shape) for item in randomize(MAP, seed, split).items}


def test_official_variants_are_learned_from_and_those_with_an_item_as_designed_are_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    official, train = _variants(tmp_path, "official"), _variants(tmp_path, "train")
    designed = {(item.size, item.shape) for item in MAP.items}
    assert designed.isdisjoint(pairs_of("official", MAP))
    assert fair_variants(official, "official") == official and capsys.readouterr().err == ""
    fair = [path for seed, path in enumerate(train) if _pairs(seed, "train").isdisjoint(designed)]
    assert 0 < len(fair) < len(train), "otherwise this tests nothing"
    assert fair_variants([*official, *train], "official") == [*official, *fair]
    assert "of 12 on varied maps cannot be learned from" in capsys.readouterr().err


def test_held_out_combinations_are_not_learned_from(tmp_path: Path) -> None:
    train, official = _variants(tmp_path, "train"), _variants(tmp_path, "official")
    assert fair_variants(train, "held-out") == train
    fair = [path for seed, path in enumerate(official) if _pairs(seed, "official").isdisjoint(EVALUATION_PAIRS)]
    assert len(fair) < len(official) and fair_variants([*train, *official], "held-out") == [*train, *fair]


def test_where_none_is_left_the_sentence_says_what_works(tmp_path: Path) -> None:
    variant = next(seed for seed in range(99) if not _pairs(seed, "evaluation").isdisjoint(EVALUATION_PAIRS))
    recorded(tmp_path, "one", 9, the_map=randomize(MAP, variant, "evaluation"))
    space = Workspace(budget=BUDGETS["smoke"], given=(tmp_path,), evaluation="held-out")
    with pytest.raises(MatchError, match="what works is --evaluation official, or variants of `split: train`"):
        list_episodes(2, space)
