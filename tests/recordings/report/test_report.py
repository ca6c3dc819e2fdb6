"""A folder of recordings as one page."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.recordings import SeatInfo, finalise
from movingout.recordings.report.facts import GROUPINGS, EpisodeFacts, facts_of
from movingout.recordings.report.failures import Failure
from movingout.recordings.report.page import ReportPage
from movingout.recordings.report.tally import ReportTally
from movingout.recordings.report.waiting import Wait
from movingout.recordings.report.words import OWN, Phrase, Words
from movingout.recordings.storage.listing import Unreadable
from movingout.server.cli import main
from movingout.world.estimates import Estimate
from movingout.world.metrics import from_numbers
from tests.recordings.report.support import english_left
from tests.recordings.support import header, not_counted, record
from tests.support import ROOT

STOOD = Phrase("detail.stood")


def facts(episode_id: str = "one", **changes: object) -> EpisodeFacts:
    values: dict[str, object] = {
        "path": Path(f"{episode_id}.mcap"),
        "id": episode_id,
        "map": load_map("FourCorners"),
        "population": ("people", "scripted"),
        "started": "2026-11-20T10:00:00.000Z",
        "outcome": "time",
        "complete": True,
        "ticks": 20,
        "metrics": {"delivered": 1.0, "items": 4.0, **from_numbers({"tcr": 0.25, "nfd": 0.5, "wt_s": 1.0})},
        "waits": (Wait(0, 1, 0, 10),),
        "failures": (),
        "consistency": np.zeros((2, 2)),
        "presence": np.zeros((2, 48, 48), dtype=np.float32),
    }
    return EpisodeFacts(**(values | changes))  # type: ignore[arg-type]


def html(*all_facts: EpisodeFacts | Unreadable, language: str = "en") -> str:
    return ReportPage("pilot", "http://lab:8000", ReportTally.of(all_facts), Words(language)).html()


# ---- adding up ---------------------------------------------------------------------------------------------


def test_episodes_add_up_per_map_and_population() -> None:
    won = facts("two", outcome="delivered", metrics={**facts().metrics, "tcr": 0.75, "ac": 0.5})
    tally = ReportTally.of([facts(), won, facts("three", population=("idle", "idle"))])
    ((_, (_, group)),) = tally.by_map()
    assert (group.n, tally.episodes) == (2, 3)
    assert group.estimate("tcr") == pytest.approx((0.5, 0.25, 2))
    assert group.estimate("success") == pytest.approx((0.5, 0.5, 2))
    assert group.estimate("seconds") == Estimate(2.0, 0.0, 2)
    assert group.estimate("ac") == Estimate(0.5, None, 1)  # the other one carried nothing together


def test_episodes_that_are_equal_are_told_apart_from_those_that_are_not() -> None:
    """`scripted` with `scripted` plays the same episode for every seed: four of it were four, with an error of 0."""
    alike = [facts(name, played="a" * 16) for name in ("one", "two", "three")]
    assert html(*alike, facts("four")).count("<td>4 (2 distinct)</td>") == 1
    once, einmal = "± counts each episode once", "± zählt jede Episode einmal"
    assert once in html(*alike) and einmal in html(*alike, language="de")
    assert once not in html(facts(), facts("two"))


def test_copies_of_an_episode_make_no_error_smaller() -> None:
    won = {**facts().metrics, "tcr": 1.0}
    failed = facts("a", played="a", failures=(Failure("no_grasp", 0, 1, 2, 9, STOOD),))
    copies = [replace(failed, id=f"a{k}") for k in range(4)] + [
        facts(f"b{k}", played="b", metrics=won) for k in range(4)
    ]
    tally = ReportTally.of(copies)
    expected = pytest.approx((0.625, 0.375, 8))
    (group,) = tally.groups.values()
    assert tally.overall("tcr") == expected == group.estimate("tcr")
    assert tally.rate("people", "no_grasp") == pytest.approx((0.5, 0.5, 8))


def test_what_was_broken_off_is_counted_but_enters_no_mean() -> None:
    tally = ReportTally.of([facts(), facts("two", outcome="interrupted"), facts("three", complete=False)])
    assert (tally.episodes, tally.unfinished) == (1, 2)


def test_waiting_over_time_is_a_share_of_the_time_still_played() -> None:
    longer = facts("two", ticks=40, waits=(Wait(1, 1, 25, 30),), consistency=np.zeros((4, 2)))
    tally = ReportTally.of([facts(), longer])
    (group,) = tally.groups.values()
    assert group.waiting_over_time().tolist() == [[0.5, 0.0], [0.0, 0.0], [0.0, 0.5], [0.0, 0.0]]


def test_consistency_over_time_is_a_mean_over_ticks_with_gaps() -> None:
    one = facts(consistency=np.array([[5.0, 10.0], [0.0, 0.0]]))
    tally = ReportTally.of([one, facts("two", consistency=np.array([[10.0, 10.0], [0.0, 0.0]]))])
    (group,) = tally.groups.values()
    assert np.array_equal(group.consistency_over_time(), [0.75, np.nan], equal_nan=True)


def test_a_failure_rate_counts_seats_that_failed_at_least_once() -> None:
    twice = (Failure("keeps", 1, 0, 10, 40, STOOD), Failure("keeps", 1, 0, 50, 90, STOOD))
    tally = ReportTally.of([facts(failures=twice), facts("two"), facts("three"), facts("four")])
    assert tally.rate("scripted", "keeps") == pytest.approx((0.25, 0.25, 4))
    assert tally.rate("people", "keeps") == (0.0, 0.0, 4)
    assert len(tally.found) == 2


@pytest.mark.parametrize(
    ("grouping", "expected"),
    [
        ("agent", ("people", "bass@all")),
        ("seat", ("P-3f2a", "bass@all:seed=3")),
        ("kind", ("human", "agent")),
        ("source", ("live", "live")),
    ],
)
def test_recordings_are_grouped_as_asked(grouping: str, expected: tuple[str, str]) -> None:
    head = header(seats=(SeatInfo("human", "P-3f2a"), SeatInfo("agent", "bass@all:seed=3")))
    assert GROUPINGS[grouping](head) == expected


def test_people_and_the_simulated_ones_of_a_rehearsal_are_two_populations() -> None:
    head = header(seats=(SeatInfo("human", "P-3f2a"), SeatInfo("agent", "bass@all")), study={"simulated": "yes"})
    assert GROUPINGS["agent"](head) == ("simulated people", "bass@all")


# ---- the page ----------------------------------------------------------------------------------------------


def test_findings_and_waits_link_to_their_tick_in_the_replay() -> None:
    page = html(facts("one-x", failures=(Failure("stays_away", 1, 1, 12, 70, STOOD),)))
    assert 'href="http://lab:8000/replay/one-x#tick=12"' in page
    assert 'href="http://lab:8000/replay/one-x#tick=0"' in page  # the wait
    assert "Does not come when help is needed: 1" in page


def test_names_from_files_cannot_become_markup() -> None:
    nasty = "<script>alert(1)</script>"
    failure = Failure("stays_away", 0, 1, 12, 70, STOOD)
    page = html(facts(nasty, population=(nasty, "scripted"), failures=(failure,)), Unreadable(Path(nasty), nasty))
    assert "<script" not in page
    assert page.count("&lt;script&gt;alert(1)") >= 5  # legend, table, group, rate, file


def test_unreadable_files_are_listed_with_their_problem() -> None:
    page = html(facts(), Unreadable(Path("torn.mcap"), "torn.mcap is incomplete: its end is missing"))
    assert "1 file cannot be read" in page and "its end is missing" in page


def test_a_folder_without_results_says_so() -> None:
    assert "no results to show" in html(facts(outcome="stopped"))


def test_the_page_asks_the_network_for_nothing_and_runs_no_script() -> None:
    page = html(facts(presence=np.ones((2, 48, 48), dtype=np.float32)))
    assert "<script" not in page and "@import" not in page and "url(" not in page
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert all(source.startswith(("data:", "http://lab:8000/replay/")) for source in sources)


def test_the_page_has_the_colours_of_the_product() -> None:
    own = (ROOT / "recordings" / "report" / "page.css").read_text(encoding="utf-8")
    web = (ROOT / "web" / "styles" / "tokens.css").read_text(encoding="utf-8")
    tokens = re.compile(r"(--[\w-]+):\s*(#[0-9a-f]{6})")
    light, dark = (dict(tokens.findall(text)) for text in own.split("@media (prefers-color-scheme: dark)", 1))
    web_light, web_dark = web.split("@media (prefers-color-scheme: dark)", 1)
    assert light.items() <= dict(tokens.findall(web_light)).items()
    assert dark.items() <= dict(tokens.findall(web_dark)).items()


def test_variants_of_a_map_share_a_group_and_their_items_are_not_drawn() -> None:
    drawn = html(facts())
    varied = [facts(seed, map=replace(load_map("FourCorners"), variant=seed)) for seed in ("seed-3", "seed-4")]
    assert 'class="item"' in drawn and 'class="item"' not in html(*varied)
    assert "Four Corners, varied</th>" in html(*varied)


def test_maps_as_designed_and_varied_ones_have_rows_of_their_own() -> None:
    """One mean was over Challenge 1 and Challenge 2, and nothing said so."""
    both = [facts(), facts("two", map=replace(load_map("FourCorners"), variant="seed-3"))]
    tally = ReportTally.of(both)
    assert [(spec.name, group.challenge, group.n) for spec, (group,) in tally.by_map()] == [
        ("FourCorners", 1, 1),
        ("FourCorners", 2, 1),
    ]
    assert "(Challenge 2) have rows of their own" in html(*both)
    assert "rows of their own" not in html(*both[:1]) + html(*both[1:])


def test_who_stands_for_several_agents_is_said() -> None:
    """`onnx:path=a.onnx` and `onnx:path=b.onnx` were one row `onnx`, without a word."""
    two = [facts(name, population=("people", "onnx"), agents=("", f"onnx:path={name}.onnx")) for name in "ab"]
    assert ReportTally.of(two).pooled == {"onnx": ["onnx:path=a.onnx", "onnx:path=b.onnx"]}
    assert "onnx stands for 2 agents: onnx:path=a.onnx, onnx:path=b.onnx. With --by seat" in html(*two)
    assert "onnx steht für 2 Agenten: onnx:path=a.onnx," in html(*two, language="de")
    assert "stands for" not in html(two[0], replace(two[0], id="c"))


def test_scripted_people_of_one_population_stand_for_it_without_a_word() -> None:
    """Every report with scripted people said that `person` stands for many agents."""
    a01, a02, b01 = (
        facts(name, population=("idle", "person"), agents=("idle", f"person:name={name}"))
        for name in ("A01", "A02", "B01")
    )
    assert ReportTally.of([a01, a02]).pooled == {}
    assert ReportTally.of([a02, b01]).pooled == {"person": ["person:name=A02", "person:name=B01"]}


def test_different_maps_of_one_name_have_rows_of_their_own() -> None:
    """Those before and after a file was edited were one row, drawn on the first of them."""
    before = replace(load_map("FourCorners"), name="Own", title="Own", number=0)
    after = replace(before, goals=before.goals[1:])
    variant = replace(after, variant="seed-3", items=after.items[:1])
    episodes = [facts(name, map=spec) for name, spec in (("a", before), ("b", after), ("c", variant), ("d", before))]
    tally = ReportTally.of(episodes)
    assert [(spec.name, spec.variant, group.n) for spec, (group,) in tally.by_map()] == [
        ("Own.1", "", 2),
        ("Own.2", "", 1),
        ("Own.2", "seed-3", 1),
    ]
    assert tally.maps_of_one_name == {"Own": ["a.mcap", "b.mcap"]}
    assert "2 different maps are called Own: Own.1 is that of a.mcap, Own.2 is that of b.mcap." in html(*episodes)
    assert "2 verschiedene Karten heißen Own: Own.1 ist die aus a.mcap," in html(*episodes, language="de")


def test_variants_that_may_be_of_two_maps_are_no_third_one() -> None:
    """The page said that three maps have the name."""
    one = replace(load_map("FourCorners"), name="Own", title="Own", number=0)
    two = replace(one, items=one.items[:1])
    varied = [replace(one, variant="seed-3"), replace(two, variant="seed-4")]
    tally = ReportTally.of(
        facts(name, map=spec) for name, spec in zip("abcd", [varied[0], one, two, varied[1]], strict=True)
    )
    found = [(spec.name, group.n) for spec, (group,) in tally.by_map()]
    assert found == [("Own.1", 1), ("Own.1+2", 2), ("Own.2", 1)]
    assert tally.maps_of_one_name == {"Own": ["b.mcap", "c.mcap"]}


def test_a_german_report_is_german_throughout() -> None:
    failure = Failure("no_grasp", 1, 1, 12, 70, Phrase("detail.not_taken", {"count": 2}))
    page = html(
        facts(failures=(failure,), consistency=np.array([[1.0, 2.0]])),
        facts("two", complete=False),
        Unreadable(Path("torn.mcap"), "torn.mcap: ."),
        language="de",
    )
    assert '<html lang="de">' in page
    assert english_left(page, OWN) == []
    for sentence in ("Vier Ecken", "2 Versuche, nahm ihn nicht", "0,25", "Menschen", "hielt 1,0 s lang allein"):
        assert sentence in page, sentence


# ---- the command -------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two episodes that ran out of time, one stopped, and a broken file."""
    place = tmp_path / "pilot"
    place.mkdir()
    for name, outcome in (("a", "time"), ("b", "time"), ("c", "stopped")):
        journal, _ = record(place, 40, outcome, episode_id=name)  # type: ignore[arg-type]
        finalise(journal)
    (place / "broken.mcap").write_bytes(b"nothing")
    return place


def test_a_report_is_written_and_broken_files_are_never_fatal(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "report.html"
    assert main(["recordings", "report", str(folder), "-o", str(out), "--workers", "1", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["episodes"], document["broken_off"], len(document["unreadable"])) == (2, 1, 1)
    (group,) = document["groups"]
    assert (group["challenge"], document["maps_of_one_name"]) == (1, {})
    assert (group["map"], group["blue"], group["red"], group["episodes"]) == ("HandOff", "people", "scripted", 2)
    assert group["tcr"].keys() == {"mean", "stderr", "n"}
    page = out.read_text(encoding="utf-8")
    assert "Report on pilot" in page and "broken.mcap" in page
    assert [path for path in tmp_path.iterdir() if out.name in path.name] == [out]


def test_several_processes_find_what_one_finds(folder: Path, tmp_path: Path) -> None:
    pages = []
    for workers in ("1", "2"):
        out = tmp_path / f"{workers}.html"
        assert main(["recordings", "report", str(folder), "-o", str(out), "--workers", workers]) == 0
        pages.append(out.read_text(encoding="utf-8"))
    assert pages[0] == pages[1]


def test_a_recording_gives_its_facts(folder: Path) -> None:
    found = facts_of(folder / "a.mcap", "agent")
    assert isinstance(found, EpisodeFacts)
    assert (found.agents, facts_of(folder / "a.mcap", "seat").agents) == (("", "scripted"), ("", ""))  # type: ignore[union-attr]
    assert (found.id, found.ticks, found.population, found.finished) == ("a", 40, ("people", "scripted"), True)
    assert found.presence.sum(axis=(1, 2)) == pytest.approx([4.0, 4.0])


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["nowhere"], "there is no such file or folder"),
        (["."], "there are no recordings in"),
        ([".", "--server", "lab:8000"], "is not the address of a server"),
        ([".", "-o", "episode.mcap"], "should end in .html"),
    ],
)
def test_wrong_use_gets_a_sentence(
    arguments: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["recordings", "report", *arguments]) == 2
    assert sentence in capsys.readouterr().err


def test_a_page_that_cannot_be_written_gets_a_sentence(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "nowhere" / "report.html"
    assert main(["recordings", "report", str(folder), "-o", str(out), "--workers", "1"]) == 2
    assert "cannot write" in capsys.readouterr().err


def test_an_episode_that_ended_before_its_first_tick_is_reported_like_any_other(tmp_path: Path) -> None:
    journal, _ = record(tmp_path, 0, "stopped")
    found = facts_of(journal, "agent")
    assert isinstance(found, EpisodeFacts)
    assert (found.ticks, found.waits, found.failures) == (0, (), ())
    assert "no results to show" in html(found)


def test_a_rehearsal_does_not_pass_for_people() -> None:
    page = html(facts(), facts("two", simulated=True))
    assert "1 recording is of a rehearsal: its participants were simulated" in page
    assert "rehearsal" not in html(facts())


def test_tutorials_are_counted_and_nothing_else_is_shown_of_them() -> None:
    tally = ReportTally.of([facts(), facts("two", tutorial=True)])
    assert (tally.episodes, tally.unfinished, tally.tutorials) == (1, 0, 1)
    assert "1 recording of a tutorial is left out." in html(facts(), facts("two", tutorial=True))


@pytest.mark.slow
def test_copies_and_rounds_that_the_study_does_not_count_are_left_out_and_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A backup in a folder below made every episode count twice, with half the standard error."""
    place, out = tmp_path / "recordings", tmp_path / "report.html"
    for name in ("a", "b", "invalid"):
        finalise(record(place, 5, episode_id=name)[0])
    shutil.copytree(place, place / "backup")
    not_counted(tmp_path, "invalid")
    command = ["recordings", "report", str(place), "-o", str(out), "--workers", "1"]
    assert main(command) == 0
    assert (
        ": 2 episodes, 0 failure cases; left out: 2 not counted by their study, 2 copies\n" in capsys.readouterr().out
    )
    page = out.read_text(encoding="utf-8")
    assert "2 copies of recordings are left out." in page
    assert "2 recordings are left out, because their study does not count them." in page
    assert main([*command, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert [document[name] for name in ("episodes", "uncounted", "copies")] == [2, 2, 2]
