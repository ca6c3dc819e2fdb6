"""Generated maps: the same from the same seed, playable by their plan, of the kind that was asked for."""

import hashlib
import json
from collections.abc import Sequence

import pytest

from movingout.maps import MapError, MapSpec, load_map, map_from_json, map_to_json
from movingout.maps.check import check_map
from movingout.maps.generated import generator
from movingout.maps.generated.generator import generate
from movingout.maps.generated.names import MODE_WORDS, SPLITS, Split, read_name, split_of
from movingout.maps.generated.proved import proved_maps, ticks_needed
from movingout.maps.selection import selected_maps
from movingout.maps.spec import Mode

DIGESTS = {"coordination": "bf4cb034354f", "awareness": "85a21c33ab40", "action consistency": "54360266d29b"}


def digest(specs: Sequence[MapSpec]) -> str:
    """Of the geometry alone: titles may change."""
    documents = [{**map_to_json(spec), "title": "", "description": ""} for spec in specs]
    return hashlib.sha256(json.dumps(documents).encode()).hexdigest()[:12]


@pytest.mark.parametrize("mode", MODE_WORDS)
def test_a_seed_gives_the_same_map_on_every_machine_and_in_every_version(mode: Mode) -> None:
    generator._generated.cache_clear()
    assert digest([generate(seed, mode) for seed in range(3)]) == DIGESTS[mode]


@pytest.mark.parametrize("mode", MODE_WORDS)
def test_generated_maps_can_be_played_and_are_stored_like_others(mode: Mode) -> None:
    for seed in range(3):
        spec = generate(seed, mode)
        assert check_map(spec) == ()
        assert spec.mode == mode
        assert 3 <= len(spec.items) <= 7 and 1 <= len(spec.goals) <= 3 and len(spec.walls) <= 8
        assert map_from_json(json.loads(json.dumps(map_to_json(spec)))) == spec
        assert load_map(spec.name) == spec


def test_the_modes_ask_for_what_their_names_say() -> None:
    sizes = {mode: {item.size for seed in range(3) for item in generate(seed, mode).items} for mode in MODE_WORDS}
    assert "large" not in sizes["coordination"]
    assert {"small", "middle"} <= sizes["awareness"]
    assert "large" in sizes["action consistency"]


def test_difficulties_come_by_turns_of_the_seed() -> None:
    assert generate(4, "awareness", "medium") == generate(4, "awareness")
    assert generate(4, "awareness", "hard") != generate(4, "awareness")


def test_a_map_of_another_difficulty_has_a_name_of_its_own_everywhere() -> None:
    usual, hard = generate(3, "awareness"), generate(3, "awareness", "hard")
    assert (usual.name, hard.name, hard.title) == (
        "generated:awareness:3", "generated:awareness:3:hard", "Surprise map 3, hard",
    )  # fmt: skip
    assert load_map(hard.name) == hard == map_from_json(json.loads(json.dumps(map_to_json(hard))))
    turned = load_map("generated:awareness:3:hard:mirror")
    assert turned.name == "generated:awareness:3:hard:mirror" and turned.walls != hard.walls
    assert ticks_needed(usual.name) == 218 and ticks_needed(hard.name) is None, "the pair has only played the usual one"


def test_symmetries_follow_the_name() -> None:
    turned = load_map("generated:awareness:1:mirror:rot90")
    assert turned.name == "generated:awareness:1:mirror:rot90"
    assert turned.walls != load_map("generated:awareness:1").walls
    assert load_map("generated:awareness:1:rot90:rot270") == load_map("generated:awareness:1")
    assert map_from_json(map_to_json(turned)) == turned


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("generated", "write generated:MODE:SEED, for example generated:awareness:12"),
        ("generated:awareness", "write generated:MODE:SEED"),
        ("generated:test:3", "names several maps; name one as generated:MODE:SEED"),
        ("generated:awarenes:1", "unknown mode 'awarenes' in generated:awarenes:1; did you mean awareness?"),
        ("generated:awareness:-1", "the seed in generated:awareness:-1 is a whole number from 0 to 999999"),
        ("generated:awareness:01", "is a whole number"),
        ("generated:awareness:1000000", "is a whole number"),
        ("generated:awareness:1:mirored", "unknown difficulty 'mirored' in generated:awareness:1:mirored; known: easy"),
        ("generated:awareness:3:easy", "is easy without saying so; write generated:awareness:3"),
        ("generated:awareness:3:hard:x", "write generated:MODE:SEED"),
    ],
)
def test_a_name_of_none_is_answered_with_what_would_be_one(name: str, message: str) -> None:
    with pytest.raises(MapError) as refused:
        load_map(name)
    assert message in str(refused.value)


def test_an_impossible_seed_or_mode_is_refused() -> None:
    with pytest.raises(MapError, match="no maps are generated for the mode 'practice'"):
        generate(0, "practice")
    with pytest.raises(MapError, match="a seed is a whole number from 0 to 999999, not -1"):
        generate(-1, "awareness")


@pytest.mark.parametrize("split", ["test"])
def test_the_list_of_a_split_has_maps_of_its_seeds_alone_in_all_modes(split: Split) -> None:
    names = proved_maps(split)
    assert len(names) == len(set(names)) >= 60
    assert {split_of(read_name(name)[1]) for name in names} == {split}
    assert [read_name(name)[0] for name in names[:3]] == list(MODE_WORDS)
    assert all(0 < (ticks_needed(name) or 0) <= 500 for name in names[:5])
    assert ticks_needed("generated:awareness:999999") is None


def test_splits_have_no_seed_in_common_and_all_seeds() -> None:
    assert sum(map(len, SPLITS.values())) == 1_000_000
    assert [split_of(seed) for seed in (0, 9_999, 10_000, 20_000)] == ["test", "test", "validation", "training"]


def test_the_words_of_the_option_for_maps() -> None:
    assert len(selected_maps("all")) == 12 and len(selected_maps("all:symmetries")) == 84
    assert selected_maps("HandOff,generated:test:2") == ["HandOff", *proved_maps("test", 2)]
    assert selected_maps("generated:test") == list(proved_maps("test"))
    with pytest.raises(MapError, match=r"has 1 to .* maps, not 99999"):
        selected_maps("generated:test:99999")
    with pytest.raises(MapError, match="how many maps is a whole number, not 'x'"):
        selected_maps("generated:test:x")
    with pytest.raises(MapError, match=r"there is no list of maps absent.txt"):
        selected_maps("@absent.txt")
