"""Recordings are deleted while a server finishes others: files appear, are renamed and go between two looks."""

import json
import os
import re
from pathlib import Path

import pytest

from movingout.recordings import finalise
from movingout.recordings.annotation.search import SEARCH_NAME, search_failures
from movingout.recordings.annotation.verdicts import VerdictLine, add_verdict, verdicts_of
from movingout.recordings.episode import SeatInfo
from movingout.recordings.storage.listing import Summary
from movingout.server.cli import main
from movingout.study.data import erasure
from movingout.study.data.erasure import (
    DAY_MS,
    being_recorded,
    due_now,
    erase,
    purge,
    remove_recordings,
    remove_recordings_of,
    remove_rooms,
)
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from movingout.study.errors import StudyError
from movingout.study.store.removal import UNDECIDED_S, drop_undecided, remove_participant
from movingout.study.store.store import DoneUnit
from tests.recordings.support import record
from tests.study.support import TEXT, Clock, agree, open_identities, open_store, study

PID = "P7QRS2"


def journal(folder: Path, episode: str, pid: str = PID) -> Path:
    return record(folder, ticks=3, episode_id=episode, seats=(SeatInfo("human", pid), SeatInfo("agent", "idle")))[0]


def finished_meanwhile(monkeypatch: pytest.MonkeyPatch, part: Path, whole: Path) -> None:
    """A part that somebody renames after the first look into the folder, and before it is read."""
    really = erasure._listed

    def listed(folder: Path) -> tuple[list[Summary], set[Path]]:
        found = really(folder)
        if part.exists():
            part.rename(whole)
        return found

    monkeypatch.setattr(erasure, "_listed", listed)


def test_a_part_that_becomes_a_recording_meanwhile_is_deleted_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = finalise(journal(tmp_path, "mine"))
    part = whole.rename(whole.with_name(whole.name + ".tmp"))
    finished_meanwhile(monkeypatch, part, whole)
    assert remove_recordings(tmp_path, PID, {"mine"}) == 1
    assert not any(tmp_path.glob("mine*"))


def test_somebody_elses_part_that_is_finished_meanwhile_stops_no_deletion(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    finalise(journal(tmp_path, "mine"))
    whole = finalise(journal(tmp_path, "other", "P3XYZ9"))
    part = whole.rename(whole.with_name(whole.name + ".tmp"))
    finished_meanwhile(monkeypatch, part, whole)
    assert remove_recordings(tmp_path, PID, set()) == 1
    assert [path.name for path in tmp_path.glob("*.mcap*")] == ["other.mcap"]


def test_a_round_is_being_recorded_until_its_file_is_finished(tmp_path: Path) -> None:
    mine = journal(tmp_path, "mine")
    assert being_recorded(tmp_path, {PID: set(), "PNOBODY": {"another"}}) == {PID}
    assert being_recorded(tmp_path, {"PNOBODY": {"mine"}}) == {"PNOBODY"}
    finalise(mine)
    assert being_recorded(tmp_path, {PID: {"mine"}}) == set()


def test_recordings_of_several_go_in_one_look_also_damaged_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    finalise(journal(tmp_path, "mine"))
    finalise(journal(tmp_path, "others", "PELSE1"))
    whole = finalise(journal(tmp_path, "broken", "P3XYZ9"))
    whole.write_bytes(whole.read_bytes()[:-60])
    looks: list[Path] = []
    really = erasure._listed
    monkeypatch.setattr(erasure, "_listed", lambda folder: looks.append(folder) or really(folder))  # type: ignore[func-returns-value]
    whose = {PID: set[str](), "P3XYZ9": {"broken"}, "PNOBODY": {"another"}}
    assert remove_recordings_of(tmp_path, whose) == {PID: 1, "P3XYZ9": 1, "PNOBODY": 0}
    assert [path.name for path in tmp_path.glob("*.mcap*")] == ["others.mcap"] and len(looks) == 1
    assert remove_recordings_of(tmp_path / "nowhere", {PID: ()}) == {PID: 0}


def test_a_long_journal_is_not_read_as_a_whole_to_see_who_plays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a round that is played meanwhile: each look cost megabytes of memory."""
    other, mine = journal(tmp_path, "other", "P3XYZ9"), journal(tmp_path, "mine")
    read: list[int] = []
    really = erasure._bytes

    def counted(path: Path, most: int = -1) -> bytes:
        read.append(most)
        return really(path, most)

    monkeypatch.setattr(erasure, "_bytes", counted)
    assert remove_recordings(tmp_path, PID, ()) == 1
    assert (other.exists(), mine.exists(), {*read}) == (True, False, {erasure.HEAD_BYTES})


def test_a_deletion_that_is_stopped_halfway_leaves_no_name_in_files_that_nobody_looks_into_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = finalise(journal(tmp_path, "mine"))
    search_failures(tmp_path)
    assert PID.encode() in (tmp_path / SEARCH_NAME).read_bytes()
    really = Path.unlink

    def stopped(path: Path, missing_ok: bool = False) -> None:
        really(path, missing_ok)
        if path == mine:
            raise KeyboardInterrupt

    monkeypatch.setattr(Path, "unlink", stopped)
    with pytest.raises(KeyboardInterrupt):
        remove_recordings(tmp_path, PID, ())
    assert [path.name for path in tmp_path.iterdir() if PID.encode() in path.read_bytes()] == []


def test_a_file_whose_name_is_not_utf8_stops_no_deletion_and_is_deleted_if_it_names_them(tmp_path: Path) -> None:
    odd = tmp_path / os.fsdecode(b"caf\xe9.mcap")
    finalise(journal(tmp_path, "other", "P3XYZ9")).rename(odd)
    finalise(journal(tmp_path, "mine"))
    assert remove_recordings(tmp_path, PID, {"mine"}) == 1
    assert [path for path in tmp_path.iterdir() if path.suffix == ".mcap"] == [odd]
    assert remove_recordings(tmp_path, "P3XYZ9", set()) == 1 and not odd.exists()


def test_rooms_that_name_somebody_are_deleted_also_those_that_were_not_understood(tmp_path: Path) -> None:
    folder = StudyFolder(study(), tmp_path)
    (folder.rooms / "k.3").mkdir(parents=True)
    (tmp_path / "answers").mkdir()
    named = [folder.rooms / "k.3" / name for name in ("kaaa.json", "kbbb.json.not-understood", "kccc.tmp")]
    other = folder.rooms / "k.3" / "kddd.json.not-understood"
    for path in named:
        path.write_text(f'{{"seat": "{PID}"', encoding="ascii")
    other.write_text("{", encoding="ascii")
    answers = [tmp_path / "answers" / f"{room}-0.jsonl" for room in ("kaaa", "kbbb", "kddd")]
    for path in answers:
        path.touch()
    remove_rooms(folder, PID)
    assert [path.exists() for path in (*named, other, *answers)] == [False] * 3 + [True] + [False, False, True]


@pytest.mark.parametrize("left", ["nothing", "an empty file"])
def test_identities_that_were_deleted_or_lost_are_not_made_anew(tmp_path: Path, left: str) -> None:
    """The study would be served again, and whoever comes back would begin once more."""
    folder = StudyFolder(study(), tmp_path)
    store = open_store(folder.own)
    agree(store, [PID])
    identities = folder.own / "identity.sqlite"
    if left != "nothing":
        identities.touch()
    assert due_now(folder, store).identities == purge(folder, store).identities == ()
    assert erase(folder, store, PID).identity is False
    assert not folder.has_identities and identities.exists() == (left != "nothing")


def test_a_code_that_several_may_have_finds_nobody_and_the_id_on_the_platform_does(tmp_path: Path) -> None:
    folder = StudyFolder(parse_study(TEXT.replace("codes: unique", "codes: {withdrew: STOP1}")), tmp_path)
    store, identities = open_store(folder.own), open_identities(folder.own)
    pid, _ = identities.pid("prolific", "5f3c")
    agree(store, [pid])
    store.finish(pid, "withdrew", "STOP1")
    with pytest.raises(StudyError, match="'STOP1' is the code of all who end alike"):
        erase(folder, store, "STOP1")
    assert erase(folder, store, "5f3c").pid == pid and identities.pids("5f3c") == []


@pytest.mark.parametrize("claimed", [PID, "ABCDEFGHJK"])
def test_an_id_that_is_somebody_elses_pseudonym_or_code_deletes_neither(tmp_path: Path, claimed: str) -> None:
    """A link says it, and nobody has signed it."""
    folder = StudyFolder(study(), tmp_path)
    store, identities = open_store(folder.own), open_identities(folder.own)
    other, _ = identities.pid("prolific", claimed)
    agree(store, [PID, other])
    store.finish(PID, "done", "ABCDEFGHJK")
    with pytest.raises(StudyError, match=rf"of 2 participants \({min(PID, other)}, {max(PID, other)}\)"):
        erase(folder, store, claimed)
    assert len(store.everybody()) == 2
    assert erase(folder, store, other).pid == other and erase(folder, store, PID).pid == PID


def test_purging_deletes_who_is_due_and_not_who_calls_themselves_so(tmp_path: Path) -> None:
    folder = StudyFolder(study(), tmp_path)
    clock = Clock()
    store, identities = open_store(folder.own, clock), open_identities(folder.own)
    agree(store, [PID], boxes=[])
    clock.ms += 20 * 365 * DAY_MS
    other, _ = identities.pid("prolific", PID)
    agree(store, [other])
    assert purge(folder, store).trials == (PID,)
    assert [one.pid for one in store.everybody()] == [other]


def test_of_who_has_not_finished_the_period_begins_when_they_were_last_seen(tmp_path: Path) -> None:
    """Who comes for several sessions would begin anew as somebody else, beside their unit, which stays open."""
    folder = StudyFolder(study(), tmp_path)
    clock = Clock()
    store, identities = open_store(folder.own, clock), open_identities(folder.own)
    here, gone = (identities.pid("prolific", id)[0] for id in ("5f3c", "5f3d"))
    agree(store, [here, gone])
    clock.ms += 31 * DAY_MS
    store.seen({here: clock.ms, gone: clock.ms}, {here})  # as after a pause, in which nobody is absent
    assert due_now(folder, store).identities == (gone,)
    clock.ms += 31 * DAY_MS
    assert due_now(folder, store).identities == (here, gone)


@pytest.mark.parametrize(("units", "may_return"), [(3, 2), (2, 0)])
def test_purging_says_who_can_take_part_again_while_the_study_recruits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], units: int, may_return: int
) -> None:
    """Nothing else tells that they were there. A code of the experimenter lets nobody in again."""
    text = TEXT.replace("participants: 12\n", f"participants: {units}\n")
    folder = StudyFolder(parse_study(text), tmp_path)
    store, identities = open_store(folder.own, text=text), open_identities(folder.own)
    pids = [identities.pid(source, "5f3c")[0] for source in ("prolific", "link", "code")]
    agree(store, pids)
    for number, pid in enumerate(pids[:2]):
        store.form_unit([pid])
        store.finish(pid, "done", f"CODE-{number}")
    file = tmp_path / "study.yaml"
    file.write_text(text, encoding="utf-8")
    place = ["study", "purge", str(file), "--data", str(tmp_path)]
    for arguments, verb in (([], "would be"), (["--apply"], "was")):
        assert main([*place, *arguments]) == 0
        told = capsys.readouterr().out
        assert "3 identities" in told
        warned = re.findall(rf"(\d) participants whose identity {verb} deleted can take part again", told)
        assert warned == ([f"{may_return}"] if may_return else [])
    assert main([*place, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["may_take_part_again"] == 0, "nobody is left to be deleted"


@pytest.mark.parametrize(
    ("removal", "slots"), [("purge", [0, 1]), ("forget", [1]), ("unwanted", [1]), ("one by one", [0, 1])]
)
def test_a_slot_stays_done_when_its_time_is_over_and_is_given_again_to_who_replaces_one_forgotten(
    tmp_path: Path, removal: str, slots: list[int]
) -> None:
    folder, clock = StudyFolder(study(), tmp_path), Clock()
    store = open_store(folder.own, clock)
    pairs = [["p1", "p2"], ["p3", "p4"]]
    for pair in pairs:
        for pid in pair:
            store.arrive(pid, "en")
        store.form_unit(pair)
        for pid in pair:
            store.finish(pid, "done", f"CODE-{pid}")
        clock.ms += 20 * 365 * DAY_MS * (pair is pairs[0])
    if removal == "unwanted":
        store.keep_data("p2", keep=False)
    if removal in ("forget", "one by one"):
        remove_participant(store, "p1", 0, expired=removal == "one by one")
    purge(folder, store)
    assert [one.pid for one in store.everybody()] == pairs[1]
    assert sorted(store.done_units()) == [DoneUnit(slot + 1, slot, 2) for slot in slots]
    store.arrive("new", "en")
    assert store.form_unit(["new"]).slot == (2 if len(slots) == 2 else 0)


def test_a_code_means_what_it_meant_when_the_study_began(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    begun, now = (TEXT.replace("codes: unique", f"codes: {{withdrew: {code}}}") for code in ("STOP1", "STOP2"))
    folder = StudyFolder(parse_study(begun), tmp_path)
    store = open_store(folder.own, text=begun)
    agree(store, [PID])
    store.finish(PID, "withdrew", "STOP1")
    file = tmp_path / "study.yaml"
    file.write_text(now, encoding="utf-8")
    assert main(["study", "forget", str(file), "STOP1", "--data", str(tmp_path)]) == 2
    assert "'STOP1' is the code of all who end alike" in capsys.readouterr().err
    assert [one.pid for one in store.everybody()] == [PID]


def test_an_identity_is_found_where_study_and_folder_were_renamed_together(tmp_path: Path) -> None:
    begun = StudyFolder(parse_study(TEXT), tmp_path)
    store, identities = open_store(begun.own, text=TEXT), open_identities(begun.own)
    pid, _ = identities.pid("prolific", "5f3c")
    agree(store, [pid])
    store.close()
    identities.close()
    begun.own.rename(begun.own.with_name("renamed"))
    file = tmp_path / "study.yaml"
    file.write_text(TEXT.replace(f"id: {begun.study.id}", "id: renamed", 1), encoding="utf-8")
    assert main(["study", "forget", str(file), "5f3c", "--data", str(tmp_path)]) == 0
    left = open_identities(begun.own.with_name("renamed"))
    assert left.pids("5f3c") == []


@pytest.mark.parametrize("gone", [False, True])
@pytest.mark.parametrize(("promised", "today", "due"), [("30d", "5y", 1), ("5y", "30d", 1), ("5y", "5y", 0)])
def test_purging_keeps_no_data_longer_than_participants_agreed_to(
    promised: str, today: str, due: int, gone: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    begun, now = (re.sub("(?m)^  trials: .*", f"  trials: {period}", TEXT) for period in (promised, today))
    folder = StudyFolder(parse_study(begun), tmp_path)
    if gone:
        begun += "maps_of_an_earlier_version: 1\n"  # so that the rest cannot be read
    agree(open_store(folder.own, text=begun), [PID], boxes=[])  # by the clock of tests, in September 2026
    file = tmp_path / "study.yaml"
    file.write_text(now, encoding="utf-8")
    assert main(["study", "purge", str(file), "--data", str(tmp_path)]) == 0
    told = capsys.readouterr()
    assert f"due: 0 identities, {due} participants" in told.out
    assert ("participants agreed to; their periods are used" in told.err) == (promised == "30d")


def test_a_verdict_that_is_clicked_during_a_deletion_goes_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, really = tmp_path / "episode.mcap", Path.unlink
    file.touch()

    def unlink(path: Path, missing_ok: bool = False) -> None:
        if path == file:
            add_verdict(tmp_path, VerdictLine("episode:keeps:0:0:1", "confirmed", "Ada", "1"))
        really(path, missing_ok)

    monkeypatch.setattr(Path, "unlink", unlink)
    erasure._remove(tmp_path, {file})
    assert verdicts_of(tmp_path) == []


def test_who_never_consented_is_due_after_half_an_hour_where_no_server_forgets_them(tmp_path: Path) -> None:
    folder = StudyFolder(study(), tmp_path)
    clock = Clock()
    store, identities = open_store(folder.own, clock), open_identities(folder.own)
    agreed, gone, here = (identities.pid("prolific", id)[0] for id in ("5f3a", "5f3b", "5f3c"))
    coded, _ = identities.pid("code", "ABCDEFGH")
    agree(store, [agreed])
    for pid in (gone, here, coded):
        store.arrive(pid, "en")
    assert due_now(folder, store).undecided == ()
    clock.ms += round(1e3 * UNDECIDED_S)
    store.seen({here: clock.ms}, {here})
    assert set(due_now(folder, store).undecided) == set(purge(folder, store).undecided) == {gone, coded}
    assert {one.pid for one in store.everybody()} == {agreed, here}
    assert set(identities.everybody()) == {agreed, here, coded}, "a code that was given to somebody stays good"
    assert b"5f3b" not in (folder.own / "identity.sqlite").read_bytes()


@pytest.mark.parametrize("units", [1, 2])
def test_a_code_that_nobody_consented_with_is_purged_when_identities_are_and_the_study_is_full(
    tmp_path: Path, units: int
) -> None:
    text = TEXT.replace("participants: 12\n", f"participants: {units}\n")
    folder, clock = StudyFolder(parse_study(text), tmp_path), Clock()
    store, identities = open_store(folder.own, clock, text), open_identities(folder.own)
    agreed, left, unused = (identities.pid("code", code)[0] for code in ("AAAA", "BBBB", "CCCC"))
    agree(store, [agreed])
    store.arrive(left, "en")
    identities.open_session(left, "hash of their browser")
    identities.keep_parameters(left, {"SESSION_ID": "5f3b"})
    clock.ms += 29 * DAY_MS
    store.form_unit([agreed])
    store.finish(agreed, "done", "CODE")
    assert (purge(folder, store).identities, {*identities.everybody()}) == ((), {agreed, left, unused})
    assert identities.of_session("hash of their browser") is None and identities.parameters()[left] == {}
    assert b"5f3b" not in (folder.own / "identity.sqlite").read_bytes()
    clock.ms += 2 * DAY_MS
    due = {left, unused} if units == 1 else set()  # else both may still be needed
    assert {*due_now(folder, store).identities} == {*purge(folder, store).identities} == due
    assert {*identities.everybody()} == {agreed, left, unused} - due


def test_who_never_consented_is_purged_where_a_kill_came_between_the_two_databases(tmp_path: Path) -> None:
    folder = StudyFolder(study(), tmp_path)
    clock = Clock()
    store, identities = open_store(folder.own, clock), open_identities(folder.own)
    gone, coded = identities.pid("prolific", "5f3b")[0], identities.pid("code", "ABCDEFGH")[0]
    identities.open_session(coded, "hash of their browser")
    for pid in (gone, coded):
        store.arrive(pid, "en")
    drop_undecided(store, [gone, coded])
    assert purge(folder, store, unknown_too=True).undecided == (), "somebody may be arriving just now"
    clock.ms += round(1e3 * UNDECIDED_S)
    assert (
        {*due_now(folder, store, unknown_too=True).undecided}
        == {*purge(folder, store, unknown_too=True).undecided}
        == {gone, coded}
    )
    assert identities.everybody() == {coded: ("code", "ABCDEFGH")}
    assert identities.of_session("hash of their browser") is None
    assert due_now(folder, store, unknown_too=True).undecided == ()
