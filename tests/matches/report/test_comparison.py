import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.stats

from movingout.maps.generated.proved import proved_maps
from movingout.matches import GridRun, Match, MatchResult
from movingout.matches.experiment.grid import Grid, read_grid
from movingout.matches.experiment.paper_reference import paper_figures
from movingout.matches.experiment.plan import matches_of, missing_agents, planned_matches
from movingout.matches.experiment.shipped_grids import FOLDER, grid_path, shipped_grids
from movingout.matches.match import failed_result, result_from_json
from movingout.matches.report.comparison import comparison_lines, json_report, markdown_report
from movingout.matches.report.crossplay import matrix, worst_matches
from movingout.matches.report.html_page import page
from movingout.matches.report.words import LANGUAGE_FILES, report_words
from movingout.matches.results.significance import holm, stars, welch
from movingout.matches.results.table import ALL_MAPS, COPIES, EARLIER, MEASURES, markdown, rows_of
from movingout.matches.results.unanswered import UNANSWERED, UNCOUNTED
from movingout.world.estimates import estimate
from movingout.world.metrics import Metrics
from tests.matches.support import small_grid

TCR = MEASURES[0]


def _result(match: Match, tcr: float, nfd: float = 0.5, ac: float | None = None) -> MatchResult:
    metrics = Metrics.of({"tcr": tcr, "nfd": nfd, "wt_s": 1.5, "ac": ac})
    return MatchResult(match, "delivered" if tcr == 1.0 else "time", 60, 0, 4, metrics, 0.03)


def _run(grid: Grid, values: Sequence[float]) -> GridRun:
    """A run whose matches have made-up results, in the order of the grid."""
    plan = planned_matches(grid)
    found = {match: _result(match, values[k % len(values)]) for k, match in enumerate(matches_of(plan))}
    return GridRun(Path("nowhere"), grid, plan, found)


@pytest.mark.parametrize(
    ("one", "other", "p"),
    [  # R: t.test(x, y); the second by the closed form for 4 degrees of freedom, near 3/8 cos(atan(t/2))^4
        ([1.0, 2.0, 3.0, 4.0, 5.0], [2.0, 3.0, 4.0, 5.0, 6.0], 0.3465935),
        ([0.0, 0.1, 0.2], [5.0, 5.1, 5.2], 4.259e-07),
    ],
)
def test_welchs_test_gives_the_p_that_statistics_programs_give(one: list[float], other: list[float], p: float) -> None:
    found = welch(estimate(one), estimate(other))
    assert found == pytest.approx(p, rel=1e-3 if p < 1e-5 else 1e-6)


def test_welchs_test_gives_the_p_of_scipy() -> None:
    random = np.random.default_rng(0)
    for sizes in [(2, 2), (3, 40), (24, 24), (240, 120), (2000, 5)]:
        for apart in (0.0, 0.3, 1.0, 3.0):
            one, other = random.normal(0.0, 1.0, sizes[0]), random.normal(apart, 2.0, sizes[1])
            expected = scipy.stats.ttest_ind(one, other, equal_var=False).pvalue
            assert welch(estimate(one.tolist()), estimate(other.tolist())) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("other", [[1.0, 1.0], [0.5, 0.5]])
def test_without_any_spread_welchs_test_says_nothing(other: list[float]) -> None:
    """Two deterministic agents were said to differ with p = 0."""
    assert welch(estimate([1.0, 1.0]), estimate(other)) is None


def test_copies_of_an_episode_make_no_difference_certain() -> None:
    grid = small_grid(agents=["idle", "scripted"], partners=["idle"], seeds=8, maps=["HandOff"])
    plan = planned_matches(grid)
    good = {entry.match for entry in plan if entry.agent == "scripted"}

    def p_of(episodes: int) -> float | None:
        results = {}
        for match in matches_of(plan):
            play, other = match.seed % episodes, match in good
            found = _result(match, 0.4 * play / episodes + 0.5 * other)
            results[match] = replace(found, play_hash=f"{play}-{other}")
        return matrix(rows_of(plan, results), TCR).cells["idle", "idle"].p

    assert p_of(1) is None
    two, all_eight = p_of(2), p_of(8)
    assert two == pytest.approx(welch(estimate([0.0, 0.2]), estimate([0.5, 0.7])), rel=1e-9)
    assert all_eight is not None and two is not None and all_eight < 0.001 < two


def test_a_change_is_no_percentage_of_nothing_or_of_less() -> None:
    """From -0.5 to 0.5 was -200 %."""
    old, new = ([{"agent": agent_id, "label": "A"}] for agent_id in ("idle", "scripted"))
    conditions = [{"name": "old", "agents": old}, {"name": "new", "agents": new, "against": "old"}]
    grid = small_grid(agents=None, conditions=conditions, seeds=4, maps=["HandOff"])
    plan = planned_matches(grid)
    nfd = {"old": -0.5, "new": 0.5}
    results = {one.match: _result(one.match, 0.5, nfd[one.condition] + one.match.seed / 100) for one in plan}
    run = GridRun(Path("nowhere"), grid, plan, results)
    line = next(one for one in comparison_lines(run) if one.condition == "new")
    percent, p = line.change(MEASURES[1])
    assert percent is None and p is not None and p < 0.001
    assert " (–***) " in markdown_report([run])


def test_holm_corrects_for_the_number_of_tests() -> None:
    assert holm([0.01, None, 0.04, 0.03]) == [pytest.approx(0.03), None, pytest.approx(0.06), pytest.approx(0.06)]
    assert [stars(p) for p in (0.0001, 0.005, 0.03, 0.2, None)] == ["***", "**", "*", "", ""]


def test_rows_have_means_per_map_and_over_all_and_count_a_lost_match_as_nothing() -> None:
    grid = small_grid(agents=["idle"], seeds=2)
    first, *rest = matches_of(plan := planned_matches(grid))
    results = {first: failed_result(first, "it raised", seat=0)} | {match: _result(match, 0.6) for match in rest}
    rows = rows_of(plan, results)
    assert [(row.map, len(row.results), row.failed) for row in rows] == [
        (ALL_MAPS, 4, 1), ("DistancePriority", 2, 1), ("FourCorners", 2, 0),
    ]  # fmt: skip
    assert (found := rows[0].estimate(TCR)) is not None and found.mean == pytest.approx(0.45)
    assert rows[0].to_json()["wt_s"]["n"] == 3
    assert "0.300 ± 0.300" in markdown(rows)


def test_results_of_earlier_versions_have_no_hash_and_claim_no_number_of_copies() -> None:
    grid = small_grid(agents=["idle"], seeds=2)
    plan = planned_matches(grid)
    documents = [_result(match, 0.5).to_json() for match in matches_of(plan)]
    for document in documents:
        del document["play_hash"]
    old = {result.match: result for result in map(result_from_json, documents)}
    assert {row.distinct for row in rows_of(plan, old)} == {None}
    assert "distinct" not in markdown(rows_of(plan, old))
    new = {match: replace(result, play_hash="aa") for match, result in old.items()}
    assert [row.count_text for row in rows_of(plan, new)] == ["4 (1 distinct)", "2 (1 distinct)", "2 (1 distinct)"]
    assert "copies of others" in markdown_report([GridRun(Path(), grid, plan, new)])


def test_the_best_of_a_column_is_marked_and_the_others_tested_against_it() -> None:
    grid = small_grid(agents=["idle", "scripted"], partners=["idle"], seeds=8, maps=["HandOff"])
    plan = planned_matches(grid)
    good = {entry.match for entry in plan if entry.agent == "scripted"}
    results = {match: _result(match, 0.8 + match.seed / 100 if match in good else match.seed / 100)
               for match in matches_of(plan)}  # fmt: skip
    found = matrix(rows_of(plan, results), TCR)
    assert found.cells["scripted", "idle"].best
    p = found.cells["idle", "idle"].p
    assert p is not None and p < 0.001
    assert [found.strength(found.cells[agent, "idle"].estimate) for agent in ("idle", "scripted")] == [0.0, 1.0]


def test_the_worst_of_each_pairing_come_in_turn_after_the_lost_ones() -> None:
    grid = small_grid(agents=["idle", "scripted"], partners=["idle"], seeds=2, maps=["HandOff"])
    run = _run(grid, [0.1, 0.2, 1.0, 0.9])
    fault = next(match for match in run.results if match.seats == ("idle", "idle") and match.seed == 1)
    run.results[fault] = failed_result(fault, "it raised", seat=0)
    worst = worst_matches(run)
    assert [(one.ending, one.metrics.tcr) for one in worst] == [("failed", 0.0), ("time", 0.9), ("time", 0.1)]


def test_the_page_shows_everything_escaped_and_loads_nothing() -> None:
    nasty = "<script>alert('a & b')</script>"
    run = _run(small_grid(name=nasty, about=nasty), [0.1, 0.9, 0.5])
    fault = next(iter(run.results))
    run.results[fault] = failed_result(fault, nasty, seat=0)
    text = page(run)
    assert "<script" not in text
    assert text.count("&lt;script&gt;alert(&#39;a &amp; b&#39;)&lt;/script&gt;") >= 4  # title, heading, about, fault
    assert not re.search(r'(src|href)="https?:', text)
    assert "DistancePriority" in text and "0.500" in text


def test_page_and_report_are_german_where_that_is_asked_for() -> None:
    run = _run(small_grid(about=""), [0.25, 0.75])
    text = page(run, "de")
    assert '<html lang="de">' in text and "Wer mit wem" in text and "0,500" in text and "alle Karten" in text
    report = markdown_report([run], "de")
    assert "# Ergebnisse neben denen des Papers" in report and "0,500" in report
    english = json.loads((LANGUAGE_FILES / "en.json").read_text(encoding="utf-8"))
    sentences = [sentence for sentence in english.values() if len(sentence) > 12 and "{" not in sentence]
    assert [sentence for sentence in sentences if sentence in text + report] == []


def test_the_sentences_of_tables_are_the_same_everywhere() -> None:
    assert report_words().say("grid.copies") == COPIES
    counts = {"questions": 3, "asked": 14, "matches": 1, "played": 2}
    assert report_words().say("grid.unanswered", **counts) == UNANSWERED.format(**counts)
    assert [report_words().say(f"grid.{name}") for name in ("uncounted", "earlier")] == [UNCOUNTED, EARLIER]


def test_page_and_report_say_where_language_models_did_not_answer() -> None:
    run = _run(small_grid(), [0.5])
    result = next(iter(run.results.values()))
    run.results[result.match] = replace(result, counts={"red_llm_questions": 14, "red_llm_useful": 11})
    assert "no usable answer to 3 of 14 questions, in 1 of 1 matches" in page(run)
    assert "auf 3 von 14 Fragen keine brauchbare Antwort, in 1 von 1 Spielen" in markdown_report([run], "de")
    assert run.to_json()["unanswered"] == {"questions": 3, "asked": 14, "matches": 1, "played": 1}
    assert UNCOUNTED not in page(run) + markdown_report([run])
    before = replace(result.match, red="llm:model=m")
    run.results[result.match] = replace(result, match=before, ending="delivered")
    assert UNCOUNTED in page(run) and UNCOUNTED in markdown_report([run])


def test_the_report_lays_ours_beside_the_papers_and_says_what_they_are_not() -> None:
    grid = read_grid(FOLDER / "challenge-1.yaml")
    run = _run(grid.model_copy(update={"maps": ["HandOff"], "seeds": 2}), [0.4, 0.6])
    text = markdown_report([run])
    assert "equal numbers do not mean that a result was reproduced" in text
    dp = next(line for line in text.splitlines() if line.startswith("| unseen | 1 | DP |"))
    assert "0.2563 ± 0.0152 (-20.7 %)" in dp and "0.4249 ± 0.0136" in dp and "0.500 ± 0.100" in dp
    seen = next(line for line in comparison_lines(run) if (line.condition, line.label) == ("seen", "DP"))
    assert len(seen.results) == 4, "both groups together"
    json.dumps(json_report([run]), allow_nan=False)


def test_the_papers_action_consistency_stands_beside_ours_of_the_formula_and_of_its_code() -> None:
    grid = read_grid(FOLDER / "challenge-1.yaml").model_copy(update={"maps": ["HandOff"], "seeds": 2})
    plan = planned_matches(grid)
    results = {one.match: replace(_result(one.match, 0.5, ac=0.25), official_ac=0.75) for one in plan}
    run = GridRun(Path("nowhere"), grid, plan, results)
    text = markdown_report([run])
    assert "| AC here | paper | AC of the code here | paper |" in text
    dp = next(line for line in text.splitlines() if line.startswith("| seen | 1 | DP |"))
    assert dp.endswith("| 0.250 ± 0.000 | 0.8163 ± 0.0162 | 0.750 ± 0.000 | 0.8163 ± 0.0162 |")
    assert "| AC des Codes hier |" in markdown_report([run], "de")
    ours = json_report([run])["grids"][0]["lines"][0]["ours"]
    assert (ours["ac"]["mean"], ours["official_ac"]["mean"]) == (0.25, 0.75)


def test_every_shipped_protocol_is_a_valid_grid() -> None:
    assert len(shipped_grids()) >= 8
    for name in shipped_grids():
        grid = read_grid(grid_path(Path(name)))
        planned = planned_matches(grid)
        labels = {(entry.condition, entry.match.challenge, entry.agent) for entry in planned}
        assert labels
        for condition in grid.all_conditions:
            for _, challenge, label in (key for key in labels if key[0] == condition.name and condition.paper):
                assert paper_figures(condition.paper, challenge, label) or label == "Idle"


def test_families_are_met_by_the_agents_for_any_map_and_on_generated_maps_too() -> None:
    grid = read_grid(grid_path(Path("families")))
    assert {"bass@any", "dp@any"} <= {entry.agent for entry in planned_matches(grid)}
    generated = [name for name in grid.map_list if name.startswith("generated:")]
    assert generated == list(proved_maps("test", 12))


@pytest.mark.parametrize("name", ["idle-control", "scripted-population", "challenge-2-scripted"])
def test_protocols_without_learned_agents_need_nothing_that_is_not_here(name: str) -> None:
    assert missing_agents(read_grid(grid_path(Path(name)))) == []


def test_a_protocol_whose_agents_are_not_here_says_how_to_get_them() -> None:
    (sentence,) = [one for one in missing_agents(read_grid(grid_path(Path("challenge-2")))) if "mlp@c2" in one]
    command = "movingout paper tables tab:full_results_in_t2 --evaluation held-out -o data/paper-held-out"
    assert f"(to get it: {command}; then " in sentence


def test_a_run_shows_itself_as_one_line() -> None:
    run = _run(small_grid(), [0.5])
    assert repr(run) == f"<GridRun {run.grid.name}: {len(run.results)} matches in nowhere, 0 failed, 0 missing>"


@pytest.mark.parametrize("language", ["en", "de"])
def test_a_bar_in_a_name_moves_no_number_of_its_row(language: str) -> None:
    run = _run(small_grid(name="a|b"), [0.5])
    lines = markdown_report([run], language).splitlines()
    heads, *_, row = [line for line in lines if line.startswith("|")]
    assert row.startswith(r"| a\|b | 1 |")
    assert len(re.findall(r"(?<!\\)\|", row)) == len(re.findall(r"(?<!\\)\|", heads))
