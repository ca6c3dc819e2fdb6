"""Cells of maps and partners, the same episodes for every agent."""

from collections import Counter

from bench.anywhere import map_groups, runs, table
from bench.results.episode_log import Outcome, Run


def test_groups_are_disjoint_and_have_the_maps_of_their_names() -> None:
    groups = map_groups()
    assert [len(groups["12 maps"]), len(groups["mirrored, turned"])] == [12, 84]
    names = [name for maps in groups.values() for name in maps]
    assert len(names) == len(set(names))
    assert all("awareness" in name for name in groups["generated: awareness"])


def test_every_agent_plays_the_same_episodes_with_all_maps_partners_and_seats() -> None:
    maps, partners = [f"m{k}" for k in range(12)], [f"p{k}" for k in range(20)]
    made = runs("one", maps, partners, 240, 500)
    assert [(run.map, run.partner, run.seat, run.seed) for run in runs("two", maps, partners, 240, 500)] == [
        (run.map, run.partner, run.seat, run.seed) for run in made
    ]
    assert set(Counter(run.map for run in made).values()) == {20}
    assert set(Counter(run.partner for run in made).values()) == {12}
    assert Counter(run.seat for run in made) == {0: 120, 1: 120}
    assert runs("one", maps, partners, 7, 500) == made[:7]


def test_all_mirrored_and_turned_maps_are_drawn() -> None:
    maps, partners = map_groups()["mirrored, turned"], [f"p{k}" for k in range(20)]
    made = runs("one", maps, partners, 252, 500)
    assert set(Counter(run.map for run in made).values()) == {3}
    assert len({run.map.partition(":")[0] for run in made[:12]}) == 12
    assert set(Counter(run.seat for run in made).values()) == {126}


def outcome(agent: str, seed: int, tcr: float) -> Outcome:
    return Outcome(Run(agent, "p", "m", 0, seed, 500), tcr, tcr, 1.0, None, 0.0)


def test_a_cell_has_mean_error_and_the_difference_to_the_idle_partner() -> None:
    played = {
        "mine": {"12 maps": [outcome("mine", 0, 1.0), outcome("mine", 1, 0.5)]},
        "idle": {"12 maps": [outcome("idle", 0, 0.5), outcome("idle", 1, 0.5)]},
    }
    lines = table(played).splitlines()
    assert lines[2] == "| mine | 0.750 ± 0.250 (+0.250 ± 0.250) | 2 |"
    assert lines[3] == "| idle | 0.500 ± 0.000 | 2 |"
