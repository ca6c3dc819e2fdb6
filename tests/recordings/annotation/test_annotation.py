"""Findings, what annotators say about them, and how far they agree."""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread

import pytest

from movingout.maps.files.output_file import draft_of
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.match import Match
from movingout.recordings import RecordingError
from movingout.recordings.annotation import verdicts
from movingout.recordings.annotation.agreement import agreements, by_case, cohens_kappa, settled
from movingout.recordings.annotation.finding import Finding
from movingout.recordings.annotation.search import SEARCH_NAME, search_failures
from movingout.recordings.annotation.verdicts import (
    VERDICTS_NAME,
    VerdictLine,
    add_verdict,
    annotations,
    checked_annotator,
    forget_recordings,
    new_line,
    newest,
    read_verdicts,
    verdicts_of,
)
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from tests.recordings.annotation.support import TICKS, waiting_alone


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("recordings")
    for name in ("first", "second"):
        waiting_alone(place, name)
    return place


def finding(number: int, case: str = "keeps") -> Finding:
    return Finding("episode", case, 0, number, 10, 40, "")  # type: ignore[arg-type]


def line(number: int, verdict: str, annotator: str = "Ada", case: str = "keeps", at: str = "1") -> VerdictLine:
    return VerdictLine(finding(number, case).id, verdict, annotator, at)  # type: ignore[arg-type]


# ---- searching ---------------------------------------------------------------------------------------------


def test_who_does_not_come_to_help_is_found_and_keeps_its_name(folder: Path) -> None:
    search = search_failures(folder)
    assert (search.left_out, search.remaining) == (0, 0)
    first, second = search.recordings
    (found,) = first.findings
    assert (found.case, found.seat, found.item, found.end) == ("stays_away", 0, 0, TICKS + 1)
    assert found.id == f"first:stays_away:0:0:{found.start}" and found.detail == "stood still"
    assert [first.who(seat) for seat in (0, 1)] == ["bass@all", "people"] and first.study == "pilot"
    assert search_failures(folder).recordings == [first, second]  # now from what was kept


def test_what_the_official_code_counts_is_kept_as_matches_have_it(tmp_path: Path) -> None:
    matches = [Match("SingleRotation", agent, agent, 0, ticks=120) for agent in ("scripted", "idle")]
    played = {(one.waiting_share, one.official_ac) for one in Lockstep(record=tmp_path).play(matches)}
    for _ in ("searched", "kept"):
        assert {(one.waiting_share, one.official_ac) for one in search_failures(tmp_path).recordings} == played
    assert None in {ac for _, ac in played} and len({ac for _, ac in played}) == 2


def test_a_link_to_a_recording_that_is_gone_does_not_stop_the_search(tmp_path: Path) -> None:
    waiting_alone(tmp_path, "one")
    (tmp_path / "gone.mcap").symlink_to("nowhere")
    assert len(search_failures(tmp_path).recordings) == 1


def test_without_time_it_says_how_much_remains(tmp_path: Path) -> None:
    waiting_alone(tmp_path, "one")
    assert search_failures(tmp_path, 0.0).remaining + len(search_failures(tmp_path, 0.0).recordings) == 1
    assert len(search_failures(tmp_path).recordings) == 1
    (tmp_path / "one.mcap").unlink()
    assert search_failures(tmp_path).recordings == []  # what was deleted is forgotten


def test_a_broken_memory_is_made_anew_and_what_is_no_recording_is_counted(tmp_path: Path) -> None:
    waiting_alone(tmp_path, "one")
    (tmp_path / SEARCH_NAME).write_bytes(b"no database at all, but long enough to look at" * 20)
    (tmp_path / "broken.mcap").write_bytes(b"broken")
    (tmp_path / f"running.mcap{JOURNAL_SUFFIX}").write_bytes(b"")
    search = search_failures(tmp_path)
    assert (len(search.recordings), search.left_out) == (1, 1)


def test_a_name_that_is_not_utf8_is_left_out(tmp_path: Path) -> None:
    one = waiting_alone(tmp_path, "one")
    shutil.copy(one, tmp_path / os.fsdecode(b"caf\xe9.mcap"))
    search = search_failures(tmp_path)
    assert (len(search.recordings), search.left_out) == (1, 1)


# ---- verdicts ----------------------------------------------------------------------------------------------


def test_the_newest_verdict_of_each_annotator_counts(tmp_path: Path) -> None:
    add_verdict(tmp_path, line(1, "confirmed"))
    add_verdict(tmp_path, line(1, "unsure", "Bo"))
    add_verdict(tmp_path, line(1, "rejected", at="2"))
    with (tmp_path / VERDICTS_NAME).open("a", encoding="utf-8") as stream:
        stream.write('{"format": 1, "finding": "episode:keeps')  # killed while writing
    said = newest(verdicts_of(tmp_path))[finding(1).id]
    assert {name: one.verdict for name, one in said.items()} == {"Ada": "rejected", "Bo": "unsure"}


def test_a_note_with_a_line_separator_is_kept_whole(tmp_path: Path) -> None:
    said = new_line("e:keeps:0:1:10", "confirmed", "Ada", note="copied\u2028from a slide")
    add_verdict(tmp_path, said)
    assert verdicts_of(tmp_path) == [said]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("nothing", "confirmed", "Ada"), "'nothing' is not the id of a finding"),
        (("e:keeps:0:1:10", "yes", "Ada"), "'yes' is no verdict; known: confirmed, rejected, unsure"),
        (("e:keeps:0:1:10", "confirmed", " "), "an annotator's name has 1 to 40 letters"),
        (("e:keeps:0:1:10", "confirmed", "../Ada"), "an annotator's name has 1 to 40 letters"),
    ],
)
def test_what_nobody_can_have_said_is_refused(words: tuple[str, str, str], sentence: str) -> None:
    with pytest.raises(RecordingError, match=sentence):
        new_line(*words)


def test_names_of_people_in_any_language_are_names() -> None:
    written = (" Ada ", "Jürgen K.", "李", "प्रिया", "O'Brien", "O’Brien", "艾达·李")
    assert [checked_annotator(name) for name in written] == [
        "Ada", "Jürgen K.", "李", "प्रिया", "O'Brien", "O'Brien", "艾达·李",
    ]  # fmt: skip


def test_what_was_said_about_deleted_recordings_goes_with_them(tmp_path: Path) -> None:
    kept = VerdictLine("other:keeps:0:0:1", "confirmed", "Ada", "1")
    for one in (line(1, "confirmed"), kept):
        add_verdict(tmp_path, one)
    forget_recordings(tmp_path, {"episode"})
    assert verdicts_of(tmp_path) == [kept]
    forget_recordings(tmp_path / "nowhere", {"episode"})


def test_a_verdict_that_comes_while_others_are_deleted_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was added to a file that the next moment was another one."""
    new = VerdictLine("other:keeps:0:0:1", "confirmed", "Ada", "1")
    click = Thread(target=add_verdict, args=(tmp_path, new))

    @contextmanager
    def during(path: Path) -> Iterator[Path]:
        with draft_of(path) as draft:
            click.start()
            click.join(0.2)
            yield draft

    add_verdict(tmp_path, line(1, "confirmed"))
    monkeypatch.setattr(verdicts, "draft_of", during)
    forget_recordings(tmp_path, {"episode"})
    click.join(5)
    assert verdicts_of(tmp_path) == [new]


def test_lines_of_a_later_version_stay_unless_they_name_a_deleted_recording(tmp_path: Path) -> None:
    later = [f'{{"format": 2, "about": "{name}", "said": "\u2028"}}' for name in ("episode", "other")]
    file = tmp_path / VERDICTS_NAME
    file.write_text("\n".join([*later, '{"format": 1, "finding": "episode:kee']), encoding="utf-8")
    forget_recordings(tmp_path, {"episode"})
    assert file.read_text(encoding="utf-8") == later[1] + "\n"


def test_a_file_of_another_annotator_is_joined_and_one_of_another_study_refused(folder: Path, tmp_path: Path) -> None:
    recordings = search_failures(folder).recordings
    (found,) = recordings[0].findings
    mine, other = tmp_path / "bo.jsonl", tmp_path / "other.jsonl"
    for file, name, study in ((mine, found.id, "pilot"), (other, "elsewhere:keeps:0:0:1", "main-study")):
        said = {"format": 1, "finding": name, "verdict": "rejected", "annotator": "Bo", "at": "1", "study": study}
        file.write_text(json.dumps(said) + "\n", encoding="utf-8")
    assert annotations(folder, [mine], recordings)[found.id]["Bo"].verdict == "rejected"
    with pytest.raises(RecordingError, match="annotates main-study, not pilot: none of its recordings is here"):
        annotations(folder, [other], recordings)
    (tmp_path / "text.txt").write_text("hello\n", encoding="utf-8")
    with pytest.raises(RecordingError, match="is no file of annotations"):
        read_verdicts(tmp_path / "text.txt")
    with pytest.raises(RecordingError, match="there is no such file"):
        read_verdicts(tmp_path / "nothing")


# ---- agreement ---------------------------------------------------------------------------------------------


def test_more_confirmations_than_rejections_settle_a_finding() -> None:
    yes, no, unsure = (line(1, verdict) for verdict in ("confirmed", "rejected", "unsure"))
    assert [settled(lines) for lines in ([yes, unsure], [no], [yes, no, yes], [yes, no], [unsure], [])] == [
        *(True, False, True),
        *(None, None, None),
    ]


def test_a_row_per_case_counts_what_became_of_its_findings() -> None:
    findings = [finding(number) for number in range(4)] + [finding(9, "no_grasp")]
    said = newest([line(0, "confirmed"), line(1, "rejected"), line(2, "confirmed"), line(2, "rejected", "Bo")])
    keeps, stays_away, no_grasp = by_case(findings, said)
    counts = (keeps.findings, keeps.judged, keeps.confirmed, keeps.rejected, keeps.disputed)
    assert counts == (4, 3, 1, 1, 1) and keeps.precision == 0.5
    assert (no_grasp.findings, no_grasp.judged, no_grasp.precision, stays_away.findings) == (1, 0, None, 0)


def test_agreement_is_counted_where_both_were_sure() -> None:
    findings = [finding(number) for number in range(4)]
    said = [line(number, verdict) for number, verdict in enumerate(("confirmed", "rejected", "confirmed", "unsure"))]
    said += [line(number, "confirmed", "Bo") for number in (0, 1, 2, 3)]
    (pair,) = agreements(findings, newest(said))
    assert (pair.one, pair.other, pair.both, pair.same) == ("Ada", "Bo", 3, 2)
    assert agreements(findings, newest(said[:4])) == []


def test_kappa_of_a_known_table() -> None:
    """Cohen 1960, as in textbooks: 20 both yes, 15 both no, 5 and 10 apart: kappa 0.4."""
    pairs = [(True, True)] * 20 + [(True, False)] * 5 + [(False, True)] * 10 + [(False, False)] * 15
    assert cohens_kappa(pairs) == pytest.approx(0.4)
    assert cohens_kappa([(True, True)] * 3) is None
