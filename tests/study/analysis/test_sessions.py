"""Failure rates per session and the rows beside the paper's, from recordings and what annotators said."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from movingout.recordings import Event, SeatInfo, finalise
from movingout.recordings.annotation.verdicts import VERDICTS_NAME, add_verdict, new_line, verdicts_of
from movingout.recordings.report.words import Phrase, Words
from movingout.server.cli import main
from movingout.study.analysis.page import all_tables, page
from movingout.study.analysis.paper_tables import annotation_table, failure_table, paper_table, rating_table
from movingout.study.analysis.results import Flag, collect
from movingout.study.analysis.sessions import paper_label
from movingout.study.analysis.tables import LANGUAGE_FILES, performance
from movingout.study.data.erasure import erase
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import letters
from movingout.study.errors import StudyError
from movingout.study.store import Store
from movingout.study.store.tables import players, rounds
from tests.recordings.annotation.support import waiting_alone
from tests.recordings.support import begin, play
from tests.study.filled import fill, template

ONE_MAP = {"    maps: all     ": "    maps: [SingleRotation] "}
Filled = tuple[StudyFolder, Store, list[str]]


@pytest.fixture
def filled(tmp_path: Path) -> Iterator[Filled]:
    """Two participants of the paper's study on one map; in two rounds with DP it stays away from its participant."""
    study, text = template("paper", **ONE_MAP)
    place, store, pids = fill(tmp_path, study, text, 2, seed=1)
    for row in _rounds(store, "dp"):
        waiting_alone(place.recordings, row["episode"], seats=(SeatInfo("agent", "dp"), SeatInfo("human", pids[0])))
    yield place, store, pids


def _rounds(store: Store, partner: str) -> list[dict[str, Any]]:
    """The rounds in which the partner is blue."""
    seats = {one["round"]: one["seat"] for one in store.rows(players)}
    return [row for row in store.rows(rounds) if row["partner"] == partner and seats[row["id"]] == 1]


def plain(partner: str) -> str:
    return partner


def test_a_session_has_a_failure_if_a_round_has_and_the_papers_rate_stands_beside(filled: Filled) -> None:
    place, store, _ = filled
    results = collect(place.study, store, place.recordings)
    rows = {(row[0], row[1]): row[2:] for row in failure_table(results, plain).rows}
    assert rows["dp", "Does not come when help is needed"] == ("2", "2 / 2 (1.000)", "–", "44 / 64 (0.688)")
    assert rows["dp", "Fails to grasp on approach"] == ("2", "0 / 2 (0.000)", "–", "58 / 64 (0.906)")
    table = paper_table(results, plain)
    assert table is not None
    for note in (table.note, performance(results, plain).note):
        assert (
            "Where rounds are missing (see the quality flags), the means of two partners may be over different" in note
        )
    assert "where the study has other maps than the paper's twelve" in table.note
    ours, papers, *_ = table.rows
    assert ours[:4] == ("dp", "this study", "1", "4") and papers[:4] == ("DP", "paper", "1", "–")
    assert papers[4:] == ("0.386 ± 0.051", "0.555 ± 0.043", "0.489 ± 0.046", "0.805 ± 0.013", "0.805 ± 0.013")
    assert ours[6].startswith("0.8")  # the share of 110 ticks in which the large item was held alone
    assert ours[8] == "–", "nothing was carried together"
    carried = tuple(replace(one, official_ac=0.75) for one in results.sessions.recordings)
    table = paper_table(replace(results, sessions=replace(results.sessions, recordings=carried)), plain)
    assert table is not None and table.heads[-2:] == ("AC ↑", "AC of the code ↑")
    assert table.rows[0][:7] == ours[:7] and table.rows[0][8] == "0.750 ± 0.000"


def test_what_the_paper_found_stands_there_with_its_own_digits(filled: Filled) -> None:
    place, store, pids = filled
    for row in _rounds(store, "bass"):
        waiting_alone(place.recordings, row["episode"], seats=(SeatInfo("agent", "bass"), SeatInfo("human", pids[0])))
    results = collect(place.study, store, place.recordings)
    papers = {(row[0], row[1]): row[-1] for row in failure_table(results, plain).rows}
    assert papers["bass", "Does not come when help is needed"] == "36 / 64 (0.563)"
    assert papers["bass", "Does not release at a hand-over"] == "22 / 64 (0.343)"
    said = "p = 0.017 of such t-tests for Helpfulness and Physics, DP/BASS above DP, 32 participants."
    assert said in rating_table(results, plain).note
    assert "p = 0,017" in rating_table(results, plain, Words("de", (LANGUAGE_FILES,))).note
    assert "0.017" not in rating_table(replace(results, blinded=True), plain).note
    alone = replace(results, study=place.study.model_copy(update={"partners": place.study.partners[:1]}))
    assert "0.017" not in rating_table(alone, plain).note, "the paper compares two models"


def test_a_round_in_which_the_partner_had_a_fault_is_flagged(filled: Filled) -> None:
    place, store, pids = filled
    row = next(one for one in store.rows(rounds) if one["partner"] == "bass")
    seats = (SeatInfo("agent", "bass"), SeatInfo("human", pids[0]))
    writer, played = begin(place.recordings, map_name=row["map"], episode_id=row["episode"], seats=seats)
    writer.event(Event(1, "agent_error", 0, detail="bass is too slow for this machine"))
    play(writer, played, 2)
    finalise(writer.close("time"))
    said = [flag for flag in collect(place.study, store, place.recordings).flags if "fault" in flag.reason.key]
    assert said == [Flag("", row["step"], Phrase("study.flag.fault", {"unit": row["unit"]}))]


@pytest.mark.slow
def test_a_blinded_report_tells_nowhere_which_letter_is_which_agent(filled: Filled, tmp_path: Path) -> None:
    place, store, _ = filled
    shuffled = place.study.model_copy(update={"shuffle_letters": True})
    seeds = (shuffled.model_copy(update={"seed": seed}) for seed in range(100))
    study = next(one for one in seeds if list(letters(one)) == ["bass", "dp"])
    results = replace(collect(study, store, place.recordings), blinded=True)
    assert results.partners == ("bass", "dp")
    assert paper_table(results, plain) is None
    table = failure_table(results, plain)
    assert "paper" not in table.heads and {len(row) for row in table.rows} == {len(table.heads)}
    text = page(results, lambda partner: letters(study)[partner], "about")
    assert "DP" not in text and "BASS" not in text and "0.386" not in text
    file = tmp_path / "study.yaml"
    file.write_text(template("paper", **ONE_MAP)[1], encoding="utf-8")
    assert (
        main(["study", "report", str(file), "--data", str(tmp_path), "-o", str(tmp_path / "blind"), "--blinded"]) == 0
    )
    written = {one.name: one.read_text(encoding="utf-8") for one in (tmp_path / "blind").glob("*.csv")}
    assert "failures.csv" in written and "paper.csv" not in written
    assert not [name for name, text in written.items() if "DP" in text or "bass" in text.casefold()]


def test_rounds_of_the_second_challenge_do_not_stand_beside_the_papers_numbers_of_the_first(tmp_path: Path) -> None:
    study, text = template("paper_challenge_2", **{"    maps: all     ": "    maps: [SingleRotation] "})
    place, store, _ = fill(tmp_path, study, text, 2, seed=1)
    table = paper_table(collect(study, store, place.recordings), plain)
    assert table is not None
    ours, papers, *_ = table.rows
    assert ours[:4] == ("dp", "this study", "2", "4") and ours[4] != "–"
    assert papers == ("DP", "paper", "2", "–", "–", "–", "–", "–", "–")


LONGER = "  - {id: longer, partners: [dp, bass], maps: [SingleRotation], seats: both, limit_ticks: 1000}\n"


def test_blocks_that_ask_other_things_of_people_are_other_sessions_and_rows(tmp_path: Path) -> None:
    study, text = template("paper", **ONE_MAP, **{"debrief:\n": f"{LONGER}\ndebrief:\n"})
    place, store, pids = fill(tmp_path, study, text, 2, seed=1)
    blue_fails = [row["episode"] for row in _rounds(store, "dp") if row["block"] == "longer" or row["unit"] == 1]
    for row in store.rows(rounds):
        if row["episode"] in blue_fails or (row["block"] == "play" and row not in _rounds(store, "dp")):
            seats = (SeatInfo("agent", "dp"), SeatInfo("human", pids[0]))
            waiting_alone(place.recordings, row["episode"], seats=seats)
    results = collect(study, store, place.recordings)
    failures = failure_table(results, plain)
    assert (failures.heads[0], failures.words) == ("Block", 3)
    stays_away = {row[0]: row[3:5] for row in failures.rows if row[1] == "dp" and "help" in row[2]}
    assert stays_away == {"play": ("3", "1 / 3 (0.333)"), "longer": ("2", "2 / 2 (1.000)")}
    table = paper_table(results, plain)
    assert table is not None and table.heads[:2] == ("Block", "Partner")
    ours = [row[:5] for row in table.rows if row[1] == "dp"]
    assert ours == [(block, "dp", "this study", "1", "4") for block in ("play", "longer")]


@pytest.mark.slow
def test_what_annotators_reject_is_not_confirmed(filled: Filled) -> None:
    place, store, _ = filled
    one, other = collect(place.study, store, place.recordings).sessions.findings
    add_verdict(place.recordings, new_line(one.id, "confirmed", "Ada"))
    add_verdict(place.recordings, new_line(other.id, "rejected", "Ada"))
    results = collect(place.study, store, place.recordings)
    row = next(row for row in failure_table(results, plain).rows if "help" in row[1])
    assert row[4] == "1 / 2 (0.500)"
    assert [row[6] for row in annotation_table(results).rows] == ["–", "0.500", "–"]
    assert {"failures", "annotations", "agreement", "paper"} <= {table.name for table in all_tables(results, plain)}
    assert "No two annotators have judged the same finding yet." in page(results, plain, "about")


def test_annotations_of_another_study_are_refused(filled: Filled, tmp_path: Path) -> None:
    place, store, _ = filled
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    add_verdict(elsewhere, new_line("other:keeps:0:0:1", "confirmed", "Bo", study="main-study"))
    with pytest.raises(StudyError, match="annotates main-study, not pilot: none of its recordings is here"):
        collect(place.study, store, place.recordings, [elsewhere / VERDICTS_NAME])


def test_forgetting_a_participant_removes_what_was_said_about_their_rounds(filled: Filled) -> None:
    place, store, pids = filled
    for finding in collect(place.study, store, place.recordings).sessions.findings:
        add_verdict(place.recordings, new_line(finding.id, "confirmed", "Ada"))
    assert len(verdicts_of(place.recordings)) == 2
    erase(place, store, pids[0])
    assert verdicts_of(place.recordings) == []  # both recordings name the first participant


@pytest.mark.slow
def test_a_study_without_recordings_has_no_failure_rates(tmp_path: Path) -> None:
    study, text = template("paper", **ONE_MAP)
    place, store, _ = fill(tmp_path, study, text, 1)
    results = collect(study, store, place.recordings)
    assert results.sessions.sessions == () and "failures" not in {one.name for one in all_tables(results, plain)}


@pytest.mark.parametrize(
    ("agent", "label"),
    [("dp@all:lag=1", "DP"), ("bass@all:score=nfd", "DP/BASS"), ("mlp@all", ""), ("my.package:Agent", ""), ("", "")],
)
def test_agents_stand_beside_the_paper_by_their_kind(agent: str, label: str) -> None:
    assert paper_label(agent) == label
