"""The report of a filled study: what it shows, what it leaves out, and that it needs nothing from anywhere."""

import codecs
import csv
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import get_args

import pytest
from sqlalchemy import update

from movingout.recordings.report.words import OWN, Words
from movingout.server.cli import main
from movingout.study.analysis.page import all_tables, page
from movingout.study.analysis.results import Results, collect
from movingout.study.analysis.tables import (
    LANGUAGE_FILES,
    flags,
    flow,
    metric_comparisons,
    performance,
    pings,
    pings_by_participant,
    ratings,
)
from movingout.study.design.definition import SUBSTITUTE, Outcome
from movingout.study.design.localized_text import LocalizedText
from movingout.study.store import Unit
from movingout.study.store.frozen_study import freeze_study
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome, Rounds
from movingout.study.store.tables import answers, rounds
from tests.recordings.report.support import english_left
from tests.study.filled import SHORT, fill, template
from tests.study.support import TEXT, agree, open_store, rounds_of, study

pytestmark = pytest.mark.slow

FORM = "movingout-paper-nine"


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Six participants of the recommended study, on two maps."""
    small, text = template("human_study", **{"    maps: all     ": "    maps: [HandOff, LeftRight] "})
    place, store, pids = fill(tmp_path_factory.mktemp("data"), small, text, 6, seed=3)
    store.answer(pids[0], "play/1/about-partner", "about-partner", "dp", "attention", 6, "", 1.0)
    store.answer(pids[1], "play/1/about-partner", "about-partner", "bass", "attention", -1, "", 1.0)
    store.answer(
        pids[0], "play/1/about-partner", "about-partner", "dp", "comment", -1, "<script>bold</script> & strong", 1.0
    )
    return collect(small, store, place.recordings)


def plain(partner: str) -> str:
    return partner


@pytest.fixture(scope="module")
def html(results: Results) -> str:
    return page(results, plain, "about")


def test_the_table_by_partner_is_in_the_layout_of_the_papers(results: Results) -> None:
    table = performance(results, plain)
    assert table.heads == ("Partner", "rounds", "TCR ↑", "NFD ↑", "WT [s] ↓", "AC ↑")
    assert [row[:2] for row in table.rows] == [("dp", "12"), ("bass", "12"), ("mlp", "12"), ("gru", "12")]
    assert re.fullmatch(r"0\.\d{3} ± 0\.\d{3}", table.rows[0][2])


def test_every_pair_of_partners_is_compared_in_every_metric_over_participants(results: Results) -> None:
    rows = metric_comparisons(results, plain).rows
    assert len(rows) == 4 * 6
    assert rows[0][:2] == ("TCR ↑", "dp – bass") and (rows[0][3], rows[0][6]) == ("6 / 6", "6")


def test_a_wrong_attention_item_is_flagged_and_one_without_an_answer_and_the_newest_counts(results: Results) -> None:
    assert [row[2] for row in flags(results).rows] == [
        "attention item attention answered 6, not 2",
        "attention item attention not answered; 2 was expected",
    ]


def test_the_flow_counts_everybody(results: Results) -> None:
    assert dict(results.flow)["came"] == dict(results.flow)["finished"] == 6


def test_items_of_two_questionnaires_with_one_label_are_told_apart(tmp_path: Path) -> None:
    twice = {
        **SHORT,
        "    after_partner: [": "    after_round: [movingout-paper-eight]\n    after_partner: [nasa-tlx, ",
    }
    small, text = template("agent_survey", **twice)
    _, store, _ = fill(tmp_path, small, text, 3)
    found = collect(small, store, tmp_path)
    rated = [row[0] for row in ratings(found, plain).rows]
    assert {"Teamwork (movingout-paper-eight)", "Teamwork (movingout-paper-nine)", "Mental demand"} <= {*rated}
    assert len(set(rated)) == len(rated), "nothing stands there twice"
    assert "<h3>Teamwork (movingout-paper-nine)</h3>" in page(found, plain, "about")


class Page(HTMLParser):
    """Collects tags, open ones and addresses."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [value or "" for key, value in attrs if key in ("src", "href")]


def test_the_page_has_no_script_no_address_and_shows_text_as_text(html: str) -> None:
    parsed = Page()
    parsed.feed(html)
    assert "script" not in parsed.tags and parsed.addresses == []
    assert "&lt;script&gt;bold&lt;/script&gt; &amp; strong" in html
    assert parsed.tags.count("svg") >= 4 + 9


def test_the_page_has_a_bar_chart_per_likert_item_and_every_table(results: Results, html: str) -> None:
    for label in ("Teamwork", "Humanlike", "Reasonable", "Follow", "Physics", "Helpfulness", "Collision", "Future"):
        assert f"{label}: distribution of ratings by partner" in html
    for table in all_tables(results, plain):
        assert f"<h2>{table.title}</h2>" in html


def test_a_german_report_is_german_throughout(results: Results) -> None:
    words = Words("de", (LANGUAGE_FILES,))
    text = page(results, plain, "über", words, simulated=True)
    assert '<html lang="de">' in text and english_left(text, OWN, LANGUAGE_FILES) == []
    for sentence in ("Probelauf:", "Ergebnisse nach Partner", "Aufmerksamkeitsfrage attention", "stimme völlig zu"):
        assert sentence in text
    assert re.search(r"0,\d{3} ± 0,\d{3}", text) and not re.search(r"<td>0\.\d", text)
    empty = page(Results(results.study, (), (), {}, (), ()), plain, "über", words)
    assert english_left(empty, OWN, LANGUAGE_FILES) == []


def test_a_report_has_the_texts_of_the_country_that_the_study_names(results: Results) -> None:
    austrian = results.study.model_copy(update={"title": LocalizedText({"en": "A game", "de-AT": "Ein Spiel"})})
    text = page(Results(austrian, (), (), {}, (), ()), plain, "über", Words("de-AT", (LANGUAGE_FILES,)))
    assert "<h1>Ergebnisse: Ein Spiel</h1>" in text


def test_blinded_reports_know_letters_only_and_others_the_agents(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small, text = template(
        "agent_survey", **{"    maps: [HandOff, PriorityPick, SingleRotation]": "    maps: [HandOff]"}
    )
    fill(tmp_path / "data", small, text, 3)
    file = tmp_path / "study.yaml"
    file.write_text(text, encoding="utf-8")
    common = [str(file), "--data", str(tmp_path / "data")]
    assert main(["study", "report", *common, "-o", str(tmp_path / "open"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rounds"] == 6
    ended = ["screened-out", "no-partner", "partner-left", "withdrew", "dropped-out", "open", "finished"]
    assert list(told["flow"]) == ["came", "declined", "deleted", "allocated", *ended, "unwanted", "complete"]
    assert {*get_args(Outcome)} - {"done"} <= {*ended}, "nobody is left out"
    assert main(["study", "report", *common, "-o", str(tmp_path / "blind"), "--blinded"]) == 0
    with (tmp_path / "blind" / "performance.csv").open(encoding="utf-8-sig", newline="") as stream:
        assert next(csv.DictReader(stream))["Partner"] == "Partner A"
    shown = (tmp_path / "open" / "report.html").read_text(encoding="utf-8")
    assert "<h1>Results: A short game with a partner</h1>" in shown
    assert "TCR: Task completion rate" in shown and "scripted (scripted)" not in shown
    german = tmp_path / "german"
    assert main(["study", "report", *common, "-o", str(german), "--language", "de"]) == 0
    assert "<h1>Ergebnisse: A short game with a partner</h1>" in (german / "report.html").read_text(encoding="utf-8")
    for table in german.glob("*.csv"):  # for programs: the same in every language
        assert table.read_bytes().startswith(codecs.BOM_UTF8), "else Excel shows other signs for ± and ↑"
        assert table.read_bytes() == (tmp_path / "open" / table.name).read_bytes()
    assert main(["study", "report", *common, "-o", str(tmp_path / "open")]) == 2
    assert "is not overwritten" in capsys.readouterr().err


def test_a_study_in_which_nobody_came_has_a_report_too(tmp_path: Path) -> None:
    empty = collect(study(), open_store(tmp_path, text=TEXT), tmp_path)
    text = page(empty, plain, "about")
    assert empty.partners == ()
    for sentence in ("No round has been finished yet.", "There are not two partners with results", "Nobody has rated"):
        assert sentence in text


def test_rounds_that_do_not_count_and_people_who_said_no_are_left_out(tmp_path: Path) -> None:
    small, text = template(
        "agent_survey", **{"    maps: [HandOff, PriorityPick, SingleRotation]": "    maps: [HandOff]"}
    )
    _, store, pids = fill(tmp_path, small, text, 3)
    first = collect(small, store, tmp_path).rounds[0]
    Rounds(store).mark(first["episode"], valid=False)
    store.keep_data(pids[2], False)
    found = collect(small, store, tmp_path)
    assert len(found.rounds) == 6 - 1 - 2
    assert pids[2] not in {row["pid"] for row in found.answers}
    assert [row[2] for row in flags(found).rows] == [f"unit {first['unit']}: marked invalid by the experimenter"]
    assert {("finished", "3"), ("wanted their data deleted (also counted above)", "1")} <= set(flow(found).rows)


def test_nobody_is_said_to_have_marked_a_round_that_could_not_be_played(tmp_path: Path) -> None:
    store = open_store(tmp_path, text=TEXT)
    agree(store, ["p1"])
    unit = store.form_unit(["p1"], 0)
    step = rounds_of(unit.slot)[0]
    Rounds(store).leave_out(unit, step, [PlayerOutcome("p1", 0, "keyboard")])
    found = flags(collect(study(), store, tmp_path)).rows
    assert [row[1:] for row in found] == [(step.key, "unit 1: not played, because its map could not be varied")]


def test_answers_about_a_round_that_does_not_count_go_with_it_and_those_about_a_partner_stay(tmp_path: Path) -> None:
    with_both = {**SHORT, "    after_partner: [": "    after_round: [nasa-tlx]\n    after_partner: ["}
    small, text = template("agent_survey", **with_both)
    _, store, _ = fill(tmp_path, small, text, 2)
    first = collect(small, store, tmp_path).rounds[0]
    Rounds(store).mark(first["episode"], valid=False)
    found = collect(small, store, tmp_path)
    (pid,) = found.people[first["unit"]]
    mine = {row["step"] for row in found.answers if row["pid"] == pid}
    other = next(row["step"] for row in found.rounds if row["unit"] == first["unit"])
    assert mine == {f"{other}/nasa-tlx", f"play/1/{FORM}"}
    again = PlayerOutcome(pid, 0, "keyboard")
    step = next(one for one in rounds_of(0, small) if one.key == first["step"])
    Rounds(store).begin(Unit(first["unit"], 0, (pid,), paused=False), step, "again", [again])
    Rounds(store).end("again", RoundOutcome("time", 500, 0.0, 0.0, 0.0, None))
    later = {row["step"] for row in collect(small, store, tmp_path).answers if row["pid"] == pid}
    assert f"{first['step']}/nasa-tlx" in later, "one attempt at the round counts"


def test_who_played_with_an_agent_in_a_partners_place_is_apart_from_pairs(tmp_path: Path) -> None:
    short = {"    maps: all": "    maps: [HandOff]", "    rounds: 3": "    rounds: 1"}
    pairs, text = template("collect", **short)
    _, store, _ = fill(tmp_path, pairs, text, 2)
    agree(store, ["P3"])
    alone = store.form_unit(["P3"])
    step = rounds_of(alone.slot, pairs)[0]
    Rounds(store).begin(alone, step, "alone", [PlayerOutcome("P3", 0, "keyboard")])
    Rounds(store).end("alone", RoundOutcome("time", 500, 0.0, 0.0, 0.0, None))
    store.finish("P3", "done", "CODE-3")
    store.answer("P3", f"{step.block}/1/{FORM}", FORM, SUBSTITUTE, "teamwork", 2, "", 1.0)
    store.answer("P3", f"end/{FORM}", FORM, "", "teamwork", 7, "", 1.0)
    assert [row["partner"] for row in store.rows(rounds) if row["unit"] == alone.id] == [SUBSTITUTE]
    found = collect(pairs, store, tmp_path)
    assert found.partners == (SUBSTITUTE, "")
    assert (dict(found.flow)["finished"], dict(found.flow)["complete"]) == (3, 1), "one of them is no pair"
    assert found.values("tcr", SUBSTITUTE) == [0.0] and len(found.values("tcr", "")) == len(found.rounds) - 1
    assert [row[:3] for row in performance(found, plain).rows] == [
        ("fixed-maps", SUBSTITUTE, "1"), ("fixed-maps", "", "2"), ("randomized-maps", "", "1")
    ]  # fmt: skip
    with store.database.write() as connection:  # as an earlier version wrote it
        connection.execute(update(rounds).values(partner=""))
        connection.execute(update(answers).values(partner=""))
    earlier = collect(pairs, store, tmp_path)
    assert earlier.partners == (SUBSTITUTE, "")
    assert earlier.ratings(FORM, "teamwork", SUBSTITUTE) == {"P3": 2.0}
    assert earlier.ratings(FORM, "teamwork", None) == {"P3": 7.0}


def test_what_pairs_say_at_the_end_has_its_own_column_and_bar(tmp_path: Path) -> None:
    short = {"    maps: all": "    maps: [HandOff]", "    rounds: 3": "    rounds: 1"}
    pairs, text = template("collect", **short)
    _, store, pids = fill(tmp_path, pairs, text, 2)
    store.answer(pids[0], f"end/{FORM}", FORM, "", "teamwork", 7, "", 1.0)
    found = collect(pairs.model_copy(update={"at_end": [FORM]}), store, tmp_path)
    table = ratings(found, plain)
    assert table.heads[-3:] == ("Item", "", "at the end")
    assert next(row[-1] for row in table.rows if row[-3] == "Teamwork" and row[-1] != "–").startswith("7.000")
    assert "at the end: 7 by 100 %" in page(found, plain, "about")


def test_pings_are_counted_by_partner_and_participant_where_they_are_on(tmp_path: Path) -> None:
    with_pings = {"    maps: [HandOff, PriorityPick, SingleRotation]": "    maps: [HandOff]\n    pings: on"}
    small, text = template("agent_survey", **with_pings)
    place, store, pids = fill(tmp_path, small, text, 2, recorded_ticks=8, pings_of_people=2)
    results = collect(small, store, place.recordings)
    (row,) = pings(results, plain).rows
    assert row == ("scripted", "participant", "4", "8", "2.000 ± 0.000", "4", "0 of 8", "–")
    assert [row[:3] for row in pings_by_participant(results).rows] == [(pid, "2", "4") for pid in sorted(pids)]
    assert "Pings by partner" in page(results, plain, "about")


def test_a_study_without_pings_has_no_table_of_them(results: Results, html: str) -> None:
    assert results.pings == () and "Pings" not in html


def test_the_foot_of_the_page_names_all_software_that_the_study_was_run_with(tmp_path: Path) -> None:
    small, text = template("agent_survey", **SHORT)
    _, store, _ = fill(tmp_path, small, text, 1)
    about = {"movingout": "0.1", "source_sha256": "0123456789abcdef"}
    for code in (about, about | {"pymunk": "6.11"}, about | {"source_sha256": "f" * 64}, {"movingout": "0.2"}):
        freeze_study(store, small.id, text, code, {})
    file = tmp_path / "study.yaml"
    file.write_text(text, encoding="utf-8")
    out, common = tmp_path / "report", ["--data", str(tmp_path), "--language", "de"]
    assert main(["study", "report", str(file), *common, "-o", str(out)]) == 0
    said = "Software test, 0.1 (01234567) {0}, 0.1 (ffffffff) {0}, 0.2 {0}.".format("ab 2026-09-21")
    assert said in (out / "report.html").read_text(encoding="utf-8")
