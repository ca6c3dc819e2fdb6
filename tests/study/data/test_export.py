"""Exports hold everything but who it was; forgetting leaves no trace; purging keeps to the times."""

import csv
import json
from contextlib import closing
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from sqlalchemy import update

from movingout.server.cli import main
from movingout.study.analysis.results import collect
from movingout.study.data.erasure import DAY_MS, due_now, erase, purge
from movingout.study.data.export import Options, export_study
from movingout.study.errors import StudyError
from movingout.study.store import Unit
from movingout.study.store.clock import now_ms
from movingout.study.store.frozen_study import freeze_study
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome, Rounds
from movingout.study.store.tables import answers, audit, consents, notes, players, rounds, tombstones, units
from tests.study.filled import SHORT, fill, template
from tests.study.support import Clock, rounds_of


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def traces(folder: Path, *words: str) -> list[str]:
    """The files below a folder that hold one of the words."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    return sorted(
        path.relative_to(folder).as_posix() for path in files if any(w.encode() in path.read_bytes() for w in words)
    )


def test_all_formats_of_an_export_hold_the_same_rows(tmp_path: Path) -> None:
    study, text = template("human_study")
    place, store, pids = fill(tmp_path, study, text, 2)
    done = export_study(place, store, tmp_path / "out", Options())
    assert (done.rows["participants"], done.rows["rounds"], done.rows["allocation"]) == (2, 96, 96)
    for name in ("rounds", "answers", "allocation"):
        rows = read_csv(tmp_path / "out" / f"{name}.csv")
        documents = json.loads((tmp_path / "out" / f"{name}.json").read_text(encoding="utf-8"))
        assert pq.read_table(tmp_path / "out" / f"{name}.parquet").to_pylist() == documents
        assert [{key: "" if value is None else str(value) for key, value in row.items()} for row in documents] == rows
    assert {row["pid"] for row in read_csv(tmp_path / "out" / "participants.csv")} == set(pids)


def test_who_only_opened_the_link_is_in_no_export_and_no_report(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, pids = fill(tmp_path, study, text, 1)
    store.arrive("PLOOKED", "en")
    freeze_study(store, study.id, text, {"movingout": "mended"}, {})
    done = export_study(place, store, tmp_path / "out", Options(training=False))
    about = json.loads((tmp_path / "out" / "about.json").read_text(encoding="utf-8"))
    assert [one["code"]["movingout"] for one in about["code_by_time"]] == ["test", "mended"]
    assert done.rows["participants"] == 1
    assert [row["pid"] for row in read_csv(tmp_path / "out" / "participants.csv")] == pids
    flow = dict(collect(study, store, place.recordings).flow)
    assert (flow["came"], flow["open"]) == (1, 0)


def test_an_export_to_be_published_is_without_those_who_did_not_allow_it(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, pids = fill(tmp_path, study, text, 2, recorded_ticks=2)
    with store.database.write() as connection:
        connection.execute(update(consents).where(consents.c.pid == pids[0]).values(boxes='["adult", "release"]'))
    why = "1 participant did not allow publishing (the box 'release' of the consent): "
    everybody = export_study(place, store, tmp_path / "all", Options(training=False))
    assert why + "--released leaves them out, before publishing" in everybody.warnings
    released = export_study(place, store, tmp_path / "out", Options(released=True))
    assert why + "left out" in released.warnings
    for name in ("participants", "consents", "answers", "players"):
        assert {row["pid"] for row in read_csv(tmp_path / "out" / f"{name}.csv")} == {pids[0]}
    mine = {row["episode"] for row in read_csv(tmp_path / "out" / "rounds.csv")}
    assert {row["episode"] for row in read_csv(tmp_path / "out" / "recordings.csv")} == mine
    assert released.recordings == everybody.recordings / 2
    assert not traces(tmp_path / "out", pids[1])


def test_nobody_was_asked_about_publishing_where_the_consent_has_no_box_for_it(tmp_path: Path) -> None:
    study, text = template("agent_survey", **{**SHORT, "- id: release": "- id: other"})
    place, store, _ = fill(tmp_path, study, text, 1)
    warnings = export_study(place, store, tmp_path / "all", Options(training=False)).warnings
    assert not any("publishing (the box" in warning for warning in warnings)
    with pytest.raises(StudyError, match="no box 'release'"):
        export_study(place, store, tmp_path / "out", Options(released=True))


def test_a_round_that_was_played_again_is_counted_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study, text = template("agent_survey", **SHORT)
    _, store, pids = fill(tmp_path / "data", study, text, 1)
    row = store.rows(units)[0]
    unit = Unit(row["id"], row["slot"], tuple(pids), paused=False)
    Rounds(store).begin(unit, rounds_of(unit.slot, study)[0], "again", [PlayerOutcome(pids[0], 0, "keyboard")])
    file = tmp_path / "study.yaml"
    file.write_text(text, encoding="utf-8")
    common = [str(file), "--data", str(tmp_path / "data"), "-o", str(tmp_path / "out")]
    assert main(["study", "export", *common]) == 0
    assert "1 participant, 3 rounds (1 of them further attempts), 10 answers" in capsys.readouterr().out
    planned = [(row["unit"], row["step"]) for row in read_csv(tmp_path / "out" / "allocation.csv")]
    played = [(row["unit"], row["step"]) for row in read_csv(tmp_path / "out" / "rounds.csv")]
    assert sorted(played) == sorted([*planned, planned[0]]), "each attempt leads to the round that was planned"
    book = (tmp_path / "out" / "codebook.md").read_text()
    assert "there may be more rows than planned rounds" in book
    assert "recordings of a map file, and what is made of them, have the name in the file" in book


def test_what_people_typed_is_no_formula_in_a_spreadsheet(tmp_path: Path) -> None:
    study, text = template("human_study")
    place, store, pids = fill(tmp_path, study, text, 1)
    formula = '=HYPERLINK("https://example.org","your prize")'
    store.note(formula, unit=1)
    answered = store.rows(answers)[0]
    store.answer(
        pids[0], answered["step"], answered["questionnaire"], answered["partner"], answered["item"], 1, formula, 1.0
    )
    export_study(place, store, tmp_path / "out", Options())
    for name in ("answers", "notes"):
        texts = {row["text"] for row in read_csv(tmp_path / "out" / f"{name}.csv")}
        assert f"'{formula}" in texts and formula not in texts
        rows = json.loads((tmp_path / "out" / f"{name}.json").read_text(encoding="utf-8"))
        assert formula in {row["text"] for row in rows}, "other formats hold what was typed"


def test_an_export_holds_no_identity_and_no_completion_code(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, pids = fill(tmp_path / "data", study, text, 2)
    export_study(place, store, tmp_path / "out", Options())
    assert traces(tmp_path / "out", "worker-0000", "CODE-1") == []
    assert traces(tmp_path / "out", pids[0])
    assert traces(tmp_path / "data", "worker-0000")


def test_the_training_set_has_the_valid_rounds_split_so_that_nobody_is_in_both_parts(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, pids = fill(tmp_path, study, text, 4, recorded_ticks=2)
    store.keep_data(pids[3], False)
    done = export_study(place, store, tmp_path / "out", Options(test_share=0.34))
    assert (done.recordings, done.missing) == (6, []), "those of who wants the data deleted are left out"
    lines = (tmp_path / "out" / "training" / "dataset.jsonl").read_text(encoding="utf-8").splitlines()
    rows = [json.loads(line) for line in lines]
    people = {(name, row["split"]) for row in rows for name in (row["blue"], row["red"]) if name in pids}
    assert sorted(name for name, _ in people) == sorted(pids[:3])
    assert {part for _, part in people} == {"train", "test"}


def test_what_the_training_set_tells_is_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place, store, _ = fill(tmp_path, *template("agent_survey", **SHORT), 1, recorded_ticks=2)
    monkeypatch.setattr("movingout.study.data.export.export_recordings", lambda name, plan: plan.tell("Two maps."))
    assert "Two maps." in export_study(place, store, tmp_path / "out", Options(("csv",))).warnings


def test_what_is_to_be_deleted_and_still_there_is_in_no_export(tmp_path: Path) -> None:
    study, text = template("collect", **{"    maps: all": "    maps: [HandOff]", "    rounds: 3": "    rounds: 1"})
    place, store, (refuses, partner, *others) = fill(tmp_path / "data", study, text, 4, recorded_ticks=2)
    store.note("Asked why.", unit=1)
    store.note(f"{refuses} came late")
    store.note("Sunny.")
    store.keep_data(refuses, False)
    done = export_study(place, store, tmp_path / "out", Options(("csv",), training=False))
    out = {name: read_csv(tmp_path / "out" / f"{name}.csv") for name in ("answers", "rounds", "players", "notes")}
    assert {row["pid"] for row in out["answers"]} == {partner, *others}
    assert {row["pid"] for row in out["players"]} == {*others}, "a game of two goes for both"
    assert {row["unit"] for row in out["rounds"]} == {"2"}
    assert [row["text"] for row in out["notes"]] == ["Sunny."]
    left_out = sum(len(store.rows(table)) for table in (answers, rounds, players, notes)) - sum(map(len, out.values()))
    assert f"1 participant wanted their data deleted: {left_out} rows left out" in done.warnings
    kept = {row["episode"] for row in out["rounds"]}
    assert {row["episode"] for row in read_csv(tmp_path / "out" / "recordings.csv")} == kept
    assert refuses in {row["pid"] for row in read_csv(tmp_path / "out" / "participants.csv")}, "they are paid"


def test_a_recording_that_is_gone_is_reported_and_the_export_is_made(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, _ = fill(tmp_path, study, text, 1)
    assert len(export_study(place, store, tmp_path / "out", Options()).missing) == 2


def test_what_an_export_says_of_a_database_does_not_command_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study, text = template("agent_survey", **SHORT)
    (tmp_path / "study.yaml").write_text(text, encoding="utf-8")
    _, store, _ = fill(tmp_path, study, text, 1)
    with store.database.write() as connection:
        connection.execute(update(rounds).where(rounds.c.id == 1).values(episode="\x1b[31mred"))
    out = ["--no-training", "-o", str(tmp_path / "out")]
    assert main(["study", "export", str(tmp_path / "study.yaml"), "--data", str(tmp_path), *out]) == 0
    told = capsys.readouterr().out
    assert "[31mred of a round is not in" in told and "\x1b" not in told


def test_a_round_that_never_had_a_tick_misses_no_recording(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, _ = fill(tmp_path, study, text, 1)
    Rounds(store).end(store.rows(rounds)[0]["episode"], RoundOutcome("interrupted", 0, 0.0, 0.0, 0.0, None))
    assert export_study(place, store, tmp_path / "out", Options(("csv",))).missing == [store.rows(rounds)[1]["episode"]]


def test_what_was_recorded_is_read_with_the_study_as_it_began(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study, text = template("agent_survey", **SHORT)
    fill(tmp_path / "data", study, text, 1, clock=now_ms)
    file = tmp_path / "study.yaml"
    command = ["study", "export", str(file), "--data", str(tmp_path / "data"), "--formats", "csv", "-o"]
    file.write_text(f"# a remark\n{text}", encoding="utf-8")
    assert main([*command, str(tmp_path / "same")]) == 0
    assert "has changed" not in capsys.readouterr().err
    file.write_text(text.replace("[HandOff]", "[FourCorners, HandOff]"), encoding="utf-8")
    assert main([*command, str(tmp_path / "changed")]) == 0
    assert "has changed since the study began; the file from then is used" in capsys.readouterr().err
    assert {row["map"] for row in read_csv(tmp_path / "changed" / "allocation.csv")} == {"HandOff"}


def test_answers_that_few_people_share_are_pointed_out(tmp_path: Path) -> None:
    study, text = template("human_study")
    place, store, _ = fill(tmp_path, study, text, 1)
    (_, warning) = export_study(place, store, tmp_path / "out", Options(("csv",))).warnings
    assert "fewer than 5 people share an answer to: age, " in warning


def test_an_export_never_overwrites(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, _ = fill(tmp_path, study, text, 1)
    (tmp_path / "out").mkdir()
    with pytest.raises(StudyError, match="is not overwritten"):
        export_study(place, store, tmp_path / "out", Options())


def test_forgetting_leaves_no_trace_of_the_participant_in_any_file(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, (gone, stays) = fill(tmp_path, study, text, 2, recorded_ticks=2)
    store.note(f"{gone} felt unwell", unit=1)
    damaged = place.recordings / "practice.mcap.journal.unreadable"
    damaged.write_bytes(b"\x00" + gone.encode())
    shard = place.rooms / "k.17"  # of a node of a cluster
    shard.mkdir(parents=True)
    (shard / "moved.json").write_text(f'{{"seats": [{{"alias": "{gone}"}}]}}', encoding="utf-8")
    for pid in (gone, stays):  # of a server that was stopped
        (place.rooms / f"{pid == gone}.json").write_text(f'{{"seats": [{{"alias": "{pid}"}}]}}', encoding="utf-8")
    (place.rooms / "half.tmp").write_bytes(gone.encode())  # of a crash between the write and the rename
    (tmp_path / "answers").mkdir()
    (tmp_path / "answers" / "True-0.jsonl").write_text('{"text": "I am worker-0000"}', encoding="utf-8")
    store.note(f"compare with {gone} please")  # of the whole study
    Rounds(store).mark(str(store.rows(rounds)[0]["episode"]), valid=False)
    assert len(traces(tmp_path, gone)) > 4
    done = erase(place, store, gone)
    assert (done.recordings, done.identity) == (3, True) and done.rows > 10
    assert traces(tmp_path, gone, "worker-0000") == []
    assert [path.name for path in place.rooms.rglob("*.*") if path.is_file()] == ["False.json"]
    assert traces(tmp_path, stays) and len(list(place.recordings.glob("*.mcap"))) == 2
    (stone,) = store.rows(tombstones)
    assert (stone["rows"], stone["recordings"]) == (done.rows, 3)
    assert store.rows(audit)[-1]["action"] == "forget"


@pytest.mark.slow
def test_the_slot_of_who_is_forgotten_is_given_again_and_a_second_wish_is_answered(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, (gone, _) = fill(tmp_path, study, text, 2)
    erase(place, store, gone)
    assert [row["state"] for row in store.rows(units)] == ["dropped", "done"]
    with pytest.raises(StudyError, match=f"{gone} was deleted already"):
        erase(place, store, gone)
    with pytest.raises(StudyError, match="there is no participant 'PXXXXXX'"):
        erase(place, store, "PXXXXXX")


def test_who_knows_the_completion_code_alone_is_forgotten_by_that(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, (gone, _) = fill(tmp_path, study, text, 2)
    assert erase(place, store, "CODE-1-0").pid == gone
    store.arrive("P3", "en")
    store.finish("P3", "done", "CODE-2-0")
    with pytest.raises(StudyError, match="'CODE-2-0' is the pseudonym, code or ID of 2 participants"):
        erase(place, store, "CODE-2-0")


def test_the_games_of_a_pair_go_for_both_and_the_partners_answers_stay(tmp_path: Path) -> None:
    study, text = template("collect", **{"    maps: all": "    maps: [HandOff]", "    rounds: 3": "    rounds: 1"})
    place, store, (gone, stays) = fill(tmp_path, study, text, 2, recorded_ticks=2)
    erase(place, store, gone)
    assert list(place.recordings.glob("*.mcap")) == []
    assert traces(tmp_path, gone) == []
    assert store.participant(stays).outcome == "done" and store.answers(stays, "form")


def test_purging_removes_identities_first_and_everything_later_unless_it_was_released(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    clock = Clock()
    place, store, (released, other) = fill(tmp_path, study, text, 2, clock=clock)
    store.consent(released, "2", "en", "again", ["release"])
    assert due_now(place, store).identities == ()
    clock.ms += 31 * DAY_MS
    assert set(due_now(place, store).identities) == {released, other}
    assert set(purge(place, store).identities) == {released, other}
    assert purge(place, store).identities == due_now(place, store).identities == ()  # nothing is left to remove
    with closing(place.open_identities()) as identities:
        assert identities.external(other) is None
    clock.ms += 5 * 365 * DAY_MS
    assert purge(place, store).trials == (other,)
    assert [one.pid for one in store.everybody()] == [released]


def test_nobody_is_removed_behind_the_back_of_a_server_that_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study, text = template("agent_survey", **SHORT)
    folder, store, (pid,) = fill(tmp_path / "data", study, text, 1, clock=now_ms)
    file = tmp_path / "study.yaml"
    file.write_text(text, encoding="utf-8")
    place = [str(file), "--data", str(tmp_path / "data")]
    with folder.exclusive():
        for arguments in (["forget", *place, pid], ["purge", *place, "--apply"]):
            assert main(["study", *arguments]) == 2
            assert "study agent-survey is being served from" in capsys.readouterr().err
        assert main(["study", "purge", *place]) == 0
    assert store.participant(pid).pid == pid
    assert main(["study", "forget", *place, pid]) == 0


def test_the_commands_say_what_they_did(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study, text = template("agent_survey", **SHORT)
    _, _, (pid, _) = fill(tmp_path / "data", study, text, 2, clock=now_ms)
    file = tmp_path / "study.yaml"
    file.write_text(text, encoding="utf-8")
    place = [str(file), "--data", str(tmp_path / "data")]
    assert main(["study", "export", *place, "-o", str(tmp_path / "out"), "--formats", "csv"]) == 0
    assert "2 participants, 4 rounds, 20 answers, 0 recordings" in (page := capsys.readouterr().out)
    assert page.count("missing: recording") == 4
    assert main(["study", "purge", *place]) == 0
    assert "due: 0 identities, 0 participants" in capsys.readouterr().out
    assert main(["study", "forget", *place[:1], pid, *place[1:], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["identity"] is True
    assert main(["study", "forget", str(file), pid, "--data", str(tmp_path / "nothing")]) == 2
    assert "has no data in" in capsys.readouterr().err
    assert main(["study", "backup", str(file), "--data", str(tmp_path / "nothing"), "-o", str(tmp_path / "b")]) == 2
    assert "say so here too: --cluster or --database" in capsys.readouterr().err


def test_a_round_that_is_still_being_recorded_has_no_file_yet(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, _ = fill(tmp_path, study, text, 1)
    first, second = (row["episode"] for row in store.rows(rounds))
    place.recordings.mkdir(exist_ok=True)
    (place.recordings / f"{first}.mcap").write_bytes(b"finished")
    (place.recordings / f"{second}.mcap.journal").write_bytes(b"grows")
    done = export_study(place, store, tmp_path / "out", Options(("csv",), training=False))
    assert [row["file"] for row in read_csv(tmp_path / "out" / "recordings.csv")] == [f"{first}.mcap"]
    assert "rounds not finished yet, whose recordings are left out: 1" in done.warnings
    assert done.missing == []


def test_where_all_who_are_left_allow_publishing_nobody_is_warned_of(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, pids = fill(tmp_path, study, text, 1)
    store.keep_data(pids[0], False)
    warnings = export_study(place, store, tmp_path / "all", Options(training=False)).warnings
    assert any("wanted their data deleted" in warning for warning in warnings)
    assert not any("publishing (the box" in warning for warning in warnings)
