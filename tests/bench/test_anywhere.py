"""Cells of maps and partners, the same episodes for every agent."""

import json
from collections import Counter
from pathlib import Path

import pytest

from bench.anywhere import MapGroup, main, map_groups, runs
from movingout.maps import map_names


def test_groups_are_disjoint_and_have_the_maps_of_their_names() -> None:
    groups = map_groups()
    assert [len(groups["12 maps"].maps), len(groups["mirrored, turned"].maps)] == [12, 84]
    names = [(name, group.challenge) for group in groups.values() for name in group.maps]
    assert len(names) == len(set(names))
    assert all("awareness" in name for name in groups["generated: awareness"].maps)


def test_every_agent_plays_the_same_episodes_with_all_maps_partners_and_seats() -> None:
    maps, partners = [f"m{k}" for k in range(12)], [f"p{k}" for k in range(20)]
    group = MapGroup(maps)
    made = runs("one", group, partners, 240, 500)
    assert [(run.map, run.partner, run.seat, run.seed) for run in runs("two", group, partners, 240, 500)] == [
        (run.map, run.partner, run.seat, run.seed) for run in made
    ]
    assert set(Counter(run.map for run in made).values()) == {20}
    assert set(Counter(run.partner for run in made).values()) == {12}
    assert Counter(run.seat for run in made) == {0: 120, 1: 120}
    assert runs("one", group, partners, 7, 500) == made[:7]


def test_all_mirrored_and_turned_maps_are_drawn() -> None:
    maps, partners = map_groups()["mirrored, turned"], [f"p{k}" for k in range(20)]
    made = runs("one", maps, partners, 252, 500)
    assert set(Counter(run.map for run in made).values()) == {3}
    assert len({run.map.partition(":")[0] for run in made[:12]}) == 12
    assert set(Counter(run.seat for run in made).values()) == {126}


def test_challenge_2_has_another_held_out_variant_in_every_episode() -> None:
    made = runs("idle", map_groups()["Challenge 2"], ["idle"], 24, 500)
    specs = [run.match.world_map() for run in made[:3]]
    assert [spec.variant for spec in specs] == [f"challenge2-evaluation-{k}" for k in range(3)]
    assert Counter(run.map for run in made) == dict.fromkeys(map_names(), 2)


def test_the_command_prints_and_counts_what_it_played(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    few = ["--runs", "2", "--ticks", "3", "--workers", "1", "--groups", "12 maps", "Challenge 2", "--partners", "idle"]
    log = ["--log", str(tmp_path / "log.jsonl")]
    main(["--agents", "greedy", "idle", *few, *log])
    assert "| TCR, greedy minus idle | +0.000 ± 0.000 | +0.000 ± 0.000 | 2 |" in capsys.readouterr().out
    main(["--agents", "greedy", "idle", *few, *log, "--json"])
    numbers = json.loads(capsys.readouterr().out)["idle"]
    assert list(numbers) == ["greedy", "idle", "greedy minus idle"]
    cell = numbers["greedy"]["Challenge 2"]
    assert (cell["n"], cell["maps"], cell["idle_was_better"], cell["interdependence"]) == (2, 2, 0.0, None)
