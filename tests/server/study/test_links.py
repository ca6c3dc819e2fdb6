"""Who may take whose place: signed links, another browser, and people who never consented; and when a study is full."""

import asyncio
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl

import pytest

from movingout.server.cli import main
from movingout.server.host import Host
from movingout.server.settings import Settings
from movingout.server.study.api import participant_view
from movingout.server.study.arrivals.admission import Admission
from movingout.server.study.arrivals.arrival_link import LINK, Arrival, ArrivalRefused, read_arrival
from movingout.server.study.arrivals.session_service import SessionService
from movingout.server.study.arrivals.signed_links import LinkSigner
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.transaction import Transaction
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Outcome
from movingout.study.design.study_file import parse_study
from movingout.study.errors import StudyError
from movingout.study.store.removal import UNDECIDED_S
from movingout.study.store.tables import participants
from tests.server.live import ADMIN
from tests.server.study.support import PAIR, SOLO, Served, Visitor, served

LATER = 4_000_000_000
TWO_PAIRS = PAIR.replace("participants: 400", "participants: 4")


def link(study: Served, id: str, until: int = LATER) -> dict[str, str]:
    return dict(parse_qsl(LinkSigner.in_folder(study.folder.own, study.folder.study.id).query(id, until)))


def refused(answer: tuple[int, dict[str, dict[str, str]]]) -> str:
    status, body = answer
    assert status == 403, body
    return body["error"]["code"]


# ---- links of a platform, which anybody who knows an id can make ----------------------------------------------------


@pytest.mark.slow
def test_who_knows_an_id_neither_takes_the_place_nor_ejects_whoever_has_it(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        victim = study.visitor(PROLIFIC_PID="victim").go_to("questionnaire")
        assert refused(study.arrive(PROLIFIC_PID="victim")) == "other_device"
        assert victim.look()["step"]["kind"] == "questionnaire", "the victim is still there"
        assert study.alerts()[0] == "other_device"


@pytest.mark.slow
def test_the_experimenter_lets_somebody_continue_in_another_browser_once(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        first = study.visitor(PROLIFIC_PID="mover").go_to("form")
        pid = first.pid
        assert study.row(pid)["device_bound"]
        study.ask("allow-device", pid=pid)
        assert not study.row(pid)["device_bound"]
        second = study.visitor(PROLIFIC_PID="mover")
        assert second.kind == "form" and first.look()["step"]["kind"] == "ended-elsewhere"
        assert refused(study.arrive(PROLIFIC_PID="mover")) == "other_device"


def test_a_page_is_told_which_of_the_tokens_of_its_browser_was_theirs(solo: Served) -> None:
    ann, ben = (solo.visitor(PROLIFIC_PID=name).token for name in ("told-ann", "told-ben"))
    for known, replaces, was_here in (
        ([ben, ann], 1, True), ([ben, ann], None, True), (["nobody", ben], None, False), ([], None, False)
    ):  # fmt: skip
        status, answer = solo.arrive(known=known, PROLIFIC_PID="told-ann")
        assert (status, answer["replaces"], answer["was_here"]) == (200, replaces, was_here)
    assert solo.arrive(known=["nobody", ben], PROLIFIC_PID="told-new")[1]["replaces"] is None


def test_before_the_consent_a_platforms_link_may_be_opened_anywhere(solo: Served) -> None:
    solo.visitor(PROLIFIC_PID="undecided")
    assert solo.visitor(PROLIFIC_PID="undecided").kind == "consent"


# ---- signed links ---------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_signed_link_admits_and_nothing_else_does(tmp_path: Path) -> None:
    with served(tmp_path, signed=True) as study:
        good = link(study, "P01")
        changed = [good | {"id": "P02"}, good | {"until": str(LATER + 1)}, good | {"sig": good["sig"][:-1] + "!"}]
        changed += [good | {"sig": ""}, {}, {"PROLIFIC_PID": "x"}, {"id": "P01"}, good | {"sig": "ü" * 22}]
        assert {refused(study.arrive(**parameters)) for parameters in changed} == {"link"}
        assert study.visitor(**good).kind == "consent"
        other = LinkSigner("another key", study.folder.study.id).query("P01", LATER)
        assert refused(study.arrive(**dict(parse_qsl(other)))) == "link"


@pytest.mark.slow
def test_where_links_are_signed_a_code_of_the_experimenters_admits_too(tmp_path: Path) -> None:
    with served(tmp_path, signed=True) as study:
        code = study.ask("open-next")["code"]
        assert study.visitor(code=code, PROLIFIC_PID="x").kind == "consent"
        assert refused(study.arrive(code="wrong")) == "code_unknown"
        assert study.visitor(**link(study, "P01"), code="wrong").kind == "consent"


def test_with_codes_and_signed_links_who_has_neither_is_asked_for_a_code(solo: Served) -> None:
    both: dict[str, Any] = {"needs_code": True, "needs_signature": True, "signer": solo.running.signer}
    assert read_arrival(link(solo, "P01"), **both).source == "signed"
    assert read_arrival({"code": "ab-12"}, **both)[:2] == ("code", "AB12")
    with pytest.raises(ArrivalRefused) as refusal:
        read_arrival({"workerId": "W"}, **both)
    assert refusal.value.code == "code"


@pytest.mark.slow
def test_an_expired_link_begins_nothing_and_leads_back(tmp_path: Path) -> None:
    with served(tmp_path, signed=True) as study:
        assert refused(study.arrive(**link(study, "late", until=1_000_000))) == "link_expired"
        began = study.visitor(**link(study, "early"))
        began.agree()
        assert study.visitor(**link(study, "early", until=1_000_000)).kind == began.kind


def test_a_signed_link_that_lost_its_end_admits_no_stranger(solo: Served) -> None:
    good = link(solo, "P01")
    for kept in (["id"], ["id", "until"], ["until"], ["until", "sig"]):
        assert refused(solo.arrive(**{name: good[name] for name in kept})) == "link"
    assert solo.visitor(PROLIFIC_PID="with-id", id="P01").kind == "consent", "platforms say who it is"


@pytest.mark.parametrize(
    "kept",
    [
        {"STUDY_ID": "s", "SESSION_ID": "x"},
        {"assignmentId": "A1", "hitId": "H1"},
        {"PROLIFIC_ID": "5f", "STUDY_ID": "s"},
        {"PROLIFIC_PID": "  "},
        {"workerId": "", "turkSubmitTo": "https://workersandbox.mturk.com"},
    ],
)
def test_a_platforms_link_without_its_person_admits_no_stranger(kept: dict[str, str]) -> None:
    with pytest.raises(ArrivalRefused) as refusal:
        read_arrival(kept, needs_code=False)
    assert refusal.value.code == "link"
    assert read_arrival({**kept, "code": "AB12"}, needs_code=True).source == "code", "that says who it is"


def test_a_signed_link_of_another_study_is_none_of_this_one(solo: Served) -> None:
    key = (solo.folder.own / "link-key").read_text().strip()
    other = LinkSigner(key, "another-study").query("P01", LATER)
    assert refused(solo.arrive(**dict(parse_qsl(other)))) == "link"


@pytest.mark.parametrize("spoil", [lambda key: key.chmod(0o640), lambda key: key.write_text("")])
def test_a_key_of_no_use_is_told_and_never_replaced(tmp_path: Path, spoil: Callable[[Path], object]) -> None:
    made = LinkSigner.in_folder(tmp_path, "solo").query("P01", LATER)
    key = tmp_path / "link-key"
    content = key.read_bytes()
    spoil(key)
    left = key.read_bytes()
    with pytest.raises(StudyError, match="run this as the user that the server runs as"):
        LinkSigner.in_folder(tmp_path, "solo")
    assert key.read_bytes() == left, "links that were given out would end"
    key.write_bytes(content)
    key.chmod(0o600)
    assert LinkSigner.in_folder(tmp_path, "solo").query("P01", LATER) == made


@pytest.mark.skipif(os.geteuid() != 0, reason="only root meets files of others that it can read")
def test_root_shares_the_key_of_the_user_that_the_server_runs_as(tmp_path: Path) -> None:
    os.chown(tmp_path, 12345, 12345)
    own = tmp_path / "studies" / "solo"  # not there before the study is served
    made = LinkSigner.in_folder(own, "solo").query("P01", LATER)
    assert {path.stat().st_uid for path in tmp_path.rglob("*")} == {12345}, "the server could not use it"
    assert (own / "link-key").is_file() and LinkSigner.in_folder(own, "solo").query("P01", LATER) == made


@pytest.mark.slow
def test_the_command_makes_links_that_the_server_admits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(SOLO)
    address = ["--address", "https://study.example.org/", "--data", str(tmp_path / "data")]
    assert main(["study", "links", str(file), *address, "--ids", "Ann", "--number", "2", "--days", "3"]) == 0
    rows = [line.split("\t") for line in capsys.readouterr().out.splitlines()]
    assert [id for id, _ in rows] == ["Ann", "P0001", "P0002"]
    assert rows[0][1].startswith("https://study.example.org/study?id=Ann&until=")
    with served(tmp_path / "data", signed=True) as study:
        assert study.visitor(**dict(parse_qsl(rows[0][1].partition("?")[2]))).kind == "consent"
    assert (tmp_path / "data" / "studies" / "solo" / "link-key").stat().st_mode & 0o077 == 0


def test_links_come_as_one_document_on_demand(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(SOLO)
    words = ["study", "links", str(file), "--address", "https://x.example", "--data", str(tmp_path), "--ids", "Ann"]
    assert main([*words, "Bo", "Ann", "--number", "1", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["study"] == "solo" and [one["id"] for one in document["links"]] == ["Ann", "Bo", "P0001"]
    for one in document["links"]:
        given = dict(parse_qsl(one["url"].partition("?")[2]))
        assert one["url"].startswith("https://x.example/study?") and given["until"] == str(one["until"])
        signer = LinkSigner.in_folder(tmp_path / "studies" / "solo", "solo")
        assert signer.checked(given, one["until"]) == (one["id"], False)


@pytest.mark.parametrize("path", ["", "/", "/study", "/study/"])
def test_links_lead_to_the_page_that_the_server_has(
    tmp_path: Path, path: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(SOLO)
    address = ["--address", f"https://x.example{path}", "--data", str(tmp_path), "--ids", "Ann"]
    assert main(["study", "links", str(file), *address]) == 0
    assert capsys.readouterr().out.startswith("Ann\thttps://x.example/study?id=Ann&")


def test_a_server_under_a_path_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(SOLO)
    for address in ("https://x.example/lab", "https://x.example/study/study"):
        assert main(["study", "links", str(file), "--address", address, "--data", str(tmp_path), "--ids", "Ann"]) == 2
        assert "--address is like" in capsys.readouterr().err


@pytest.mark.parametrize("options", [["--ids", "a b"], ["--ids", "x" * 65], [], ["--number", "-1"], ["--ids", "a\n"]])
def test_links_for_nobody_or_with_odd_ids_are_refused_in_a_sentence(
    tmp_path: Path, options: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(SOLO)
    address = ["--address", "https://x.example", "--data", str(tmp_path)]
    assert main(["study", "links", str(file), *address, *options]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_an_id_with_a_line_break_cannot_be_signed() -> None:
    with pytest.raises(StudyError, match="up to 64"):
        LinkSigner("key", "study").query("a\n5", 5)


# ---- rows only with a consent ---------------------------------------------------------------------------------------


@pytest.mark.slow
def test_who_leaves_without_a_word_about_the_consent_leaves_no_row(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        stayed = study.visitor(PROLIFIC_PID="stayed")
        stayed.agree()
        gone = study.visitor(PROLIFIC_PID="gone")
        study.later(UNDECIDED_S + 1)
        study.look()
        store, known = study.running.databases.store, study.running.databases.identities
        assert [row["pid"] for row in store.rows(participants)] == [stayed.pid]
        assert known.known("prolific", "gone") is None
        assert gone.call("view")[0] == 401
        assert study.live.call("/api/experimenter/state", token=ADMIN)[1]["counts"]["planned"] == 400
        assert study.visitor(PROLIFIC_PID="gone").kind == "consent", "they may come again"
        code = study.ask("open-next")["code"]
        undecided = study.visitor(code=code)
        study.later(UNDECIDED_S + 1)
        study.look()
        assert undecided.call("view")[0] == 401
        assert study.visitor(code=code).kind == "consent", "a code that was given to somebody stays good"
        assert Visitor(study, stayed.token, stayed.view).look()["step"]["kind"] == stayed.kind


def test_a_page_that_is_opened_long_after_the_end_may_be_of_the_next_person(
    solo: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    visitor = solo.visitor()
    visitor.agree()
    visitor.stop(keep=True)
    assert not visitor.look()["step"]["long_ago"]
    monkeypatch.setattr(participant_view, "LONG_AGO_S", -1.0)
    assert visitor.look()["step"]["long_ago"]


# ---- a full study ----------------------------------------------------------------------------------------------------


async def begun(study: RunningStudy, tx: Transaction, people: int) -> list[ParticipantSession]:
    """A unit of so many people comes."""
    number = len(list(study.participants))
    members = [await study.participants.arrive(tx, f"P{number + one}", "en", LINK) for one in range(people)]
    await study.units.form(tx, members)
    return members


async def finished(
    study: RunningStudy, tx: Transaction, members: Sequence[ParticipantSession], outcomes: Sequence[Outcome]
) -> None:
    for session, outcome in zip(members, outcomes, strict=True):
        await study.participants.finish(tx, session, outcome)


async def ended(study: RunningStudy, tx: Transaction, *outcomes: Outcome) -> None:
    """A unit of so many people comes and goes."""
    await finished(study, tx, await begun(study, tx, len(outcomes)), outcomes)


async def is_full(study: RunningStudy) -> bool:
    try:
        await SessionService(study).arrive(Arrival(LINK, f"new-{len(list(study.participants))}", {}), "en")
    except ArrivalRefused as error:
        return error.code == "study_full"
    return False


def fresh(folder: Path) -> RunningStudy:
    return RunningStudy(
        StudyFolder(parse_study(TWO_PAIRS), folder), TWO_PAIRS, Host(Settings(data=folder)), Admission()
    )


def test_pairs_that_lack_one_and_who_played_with_an_agent_instead_leave_their_place_to_others(tmp_path: Path) -> None:
    async def test() -> None:
        study = fresh(tmp_path)
        try:
            async with study.transaction() as tx:
                await ended(study, tx, "done", "withdrew")
                await ended(study, tx, "dropped-out", "done")
                await ended(study, tx, "done", "done")
            assert (study.participants.complete_units, await is_full(study)) == (1, False)
            async with study.transaction() as tx:
                await ended(study, tx, "done")
                await ended(study, tx, "done")
            assert (study.participants.complete_units, await is_full(study)) == (1, False), "they are no pair"
            assert study.alerts.to_json() == []
            async with study.transaction() as tx:
                await ended(study, tx, "done", "done")
            assert (study.participants.complete_units, await is_full(study)) == (2, True)
            assert slots_done(study) == [0, 1, 2, 3]
        finally:
            study.databases.close()
        again = fresh(tmp_path)
        try:
            async with again.transaction() as tx:
                await again.participants.restore(tx, {})
            assert await is_full(again), "after a restart, too"
        finally:
            again.databases.close()

    asyncio.run(test())


def slots_done(study: RunningStudy) -> list[int]:
    return sorted(one.slot for one in study.databases.store.done_units())


async def is_full_after_one_more_pair(study: RunningStudy) -> bool:
    assert (study.participants.complete_units, await is_full(study)) == (1, False), "a slot is to be given again"
    async with study.transaction() as tx:
        await ended(study, tx, "done", "done")
    return (study.participants.complete_units, await is_full(study), slots_done(study)) == (2, True, [0, 1, 2])


def test_a_study_is_full_only_when_every_planned_slot_is_done(tmp_path: Path) -> None:
    """Three pairs came at once, for two slots; one of these two is left."""

    async def test() -> None:
        study = fresh(tmp_path)
        try:
            async with study.transaction() as tx:
                pairs = [await begun(study, tx, 2) for _ in range(3)]
                outcomes: tuple[Outcome, ...] = ("done", "withdrew", "done")
                for members, outcome in zip(pairs, outcomes, strict=True):
                    await finished(study, tx, members, (outcome, "done"))
            assert await is_full_after_one_more_pair(study)
        finally:
            study.databases.close()

    asyncio.run(test())


def test_a_planned_slot_that_an_earlier_version_gave_to_one_with_an_agent_is_made_up_for_by_a_pair(
    tmp_path: Path,
) -> None:
    async def test() -> None:
        study = fresh(tmp_path)
        try:
            async with study.transaction() as tx:
                session = await study.participants.arrive(tx, "P0", "en", LINK)
                await tx.run(study.databases.store.form_unit, ["P0"])
                await study.participants.refresh(tx, session)
                await finished(study, tx, [session], ["done"])
                await ended(study, tx, "done", "done")
            assert await is_full_after_one_more_pair(study)
        finally:
            study.databases.close()

    asyncio.run(test())
