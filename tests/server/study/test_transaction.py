"""Who is where changes only under the lock: a change needs a transaction, and there is one at a time."""

import asyncio
import inspect
from collections.abc import Awaitable, Callable
from math import inf
from pathlib import Path
from typing import Any

import pytest

from movingout.server.host import Host
from movingout.server.notices import NOTHING
from movingout.server.rooms.room_view import room_view
from movingout.server.settings import Settings
from movingout.server.study.api.participant_view import ParticipantViews
from movingout.server.study.arrivals.admission import Admission
from movingout.server.study.departures import Departures
from movingout.server.study.participant_actions import ParticipantActions, StudyAnswerRequest
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.participants import Participants
from movingout.server.study.progress import Progress
from movingout.server.study.rounds.finished_rounds import FinishedRounds
from movingout.server.study.rounds.study_rooms import StudyRooms
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.server.study.units import Units
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from movingout.study.errors import StoreFenced
from movingout.study.store.tables import participants
from tests.server.live import WAIT_S
from tests.server.study.support import SOLO

READERS = {
    Participants: {"get", "is_full", "scrub_identities"},
    Units: {"get", "of", "heard", "last_round", "waiting_since"},
    Progress: {"is_paused", "note_sleep", "note_standing"},
    StudyRooms: {"prepare", "map_of", "map_name", "refresh", "shown_map"},
    FinishedRounds: {
        "add", "save_soon", "saved", "count", "count_recovered", "count_stored", "count_deleted", "close_left",
    },
    Departures: {"delete_data"},
}  # fmt: skip
"""All public methods that may be called at any time; `heard` marks presence, `delete_data` begins in the background,
`scrub_identities` moves nobody."""

Change = Callable[[RunningStudy, Transaction, ParticipantSession, StudyUnit], Any]
CHANGES: dict[str, Change] = {
    "Participants.restore": lambda study, tx, one, unit: study.participants.restore(tx, {}),
    "Participants.arrive": lambda study, tx, one, unit: study.participants.arrive(tx, "PNEW", "en", "link"),
    "Participants.decline": lambda study, tx, one, unit: study.participants.decline(tx, one),
    "Participants.move": lambda study, tx, one, unit: study.participants.move(tx, one, "debrief"),
    "Participants.finish": lambda study, tx, one, unit: study.participants.finish(tx, one, "done"),
    "Participants.refresh": lambda study, tx, one, unit: study.participants.refresh(tx, one),
    "Units.restore": lambda study, tx, one, unit: study.units.restore(tx),
    "Participants.note_absences": lambda study, tx, one, unit: study.participants.note_absences(tx),
    "Participants.note_last_seen": lambda study, tx, one, unit: study.participants.note_last_seen(tx),
    "Units.blocks_over": lambda study, tx, one, unit: study.units.blocks_over(tx, unit.record.id),
    "Units.finished_steps": lambda study, tx, one, unit: study.units.finished_steps(tx, unit.record.id),
    "Units.with_rounds_left": lambda study, tx, one, unit: study.units.with_rounds_left(tx, unit),
    "Units.form": lambda study, tx, one, unit: study.units.form(tx, [one]),
    "Units.move_to_first_step": lambda study, tx, one, unit: study.units.move_to_first_step(tx, unit),
    "Units.remove": lambda study, tx, one, unit: study.units.remove(tx, unit),
    "Units.stop_waiting": lambda study, tx, one, unit: study.units.stop_waiting(tx, one),
    "Units.restart_waits": lambda study, tx, one, unit: study.units.restart_waits(tx),
    "Units.match": lambda study, tx, one, unit: study.units.match(tx),
    "Progress.advance": lambda study, tx, one, unit: study.progress.advance(tx, one),
    "Progress.skip_round": lambda study, tx, one, unit: study.progress.skip_round(tx, unit, one.steps[3]),
    "Progress.round_ended": lambda study, tx, one, unit: study.progress.round_ended(tx, unit, None),  # type: ignore[arg-type]
    "Progress.catch_up": lambda study, tx, one, unit: study.progress.catch_up(tx, unit),
    "Progress.catch_up_all": lambda study, tx, one, unit: study.progress.catch_up_all(tx),
    "Progress.restore": lambda study, tx, one, unit: study.progress.restore(tx),
    "Progress.set_paused": lambda study, tx, one, unit: study.progress.set_paused(tx, True),
    "Progress.hold_rooms": lambda study, tx, one, unit: study.progress.hold_rooms(tx),
    "StudyRooms.ask": lambda study, tx, one, unit: study.rooms.ask(tx, unit, room_view),
    "StudyRooms.hold": lambda study, tx, one, unit: study.rooms.hold(tx, unit, True),
    "StudyRooms.look": lambda study, tx, one, unit: study.rooms.look(tx, study.units),
    "StudyRooms.open": lambda study, tx, one, unit: study.rooms.open(tx, unit, one.steps[3]),
    "StudyRooms.close": lambda study, tx, one, unit: study.rooms.close(tx, unit, NOTHING),
    "Participants.drop_undecided": lambda study, tx, one, unit: study.participants.drop_undecided(tx, inf),
    "FinishedRounds.save": lambda study, tx, one, unit: study.rooms.finished.save(tx, unit),
    "StudyRooms.check": lambda study, tx, one, unit: study.rooms.check(tx, study.units, 0.0, True),
    "StudyRooms.resume": lambda study, tx, one, unit: study.rooms.resume(tx, study.units),
    "Departures.dismiss": lambda study, tx, one, unit: study.departures.dismiss(tx, one, "withdrew"),
    "Departures.decline": lambda study, tx, one, unit: study.departures.decline(tx, one),
    "Departures.release_partners": lambda study, tx, one, unit: study.departures.release_partners(tx, unit),
}


def test_every_change_takes_a_transaction_and_everything_else_only_reads() -> None:
    found = set()
    for owner, readers in READERS.items():
        methods = {name: value for name, value in inspect.getmembers(owner, inspect.isfunction) if name[0] != "_"}
        takes = {name for name, value in methods.items() if "tx" in inspect.signature(value).parameters}
        assert methods.keys() - takes == readers, owner
        found |= {f"{owner.__name__}.{name}" for name in takes}
    assert found == CHANGES.keys()


def run(tmp_path: Path, test: Callable[[RunningStudy], Awaitable[None]]) -> None:
    """Run a test on a study that is not served."""

    async def with_study() -> None:
        folder = StudyFolder(parse_study(SOLO), tmp_path)
        study = RunningStudy(folder, SOLO, Host(Settings(data=tmp_path)), Admission())
        try:
            await test(study)
        finally:
            study.databases.close()

    asyncio.run(with_study())


async def at_practice(study: RunningStudy) -> tuple[Transaction, ParticipantSession, StudyUnit]:
    """A transaction that has ended, and the participant who came to the practice in it."""
    async with study.transaction() as tx:
        session = await study.participants.arrive(tx, "PAAAAAA", "en", "link")
        await tx.run(study.databases.store.consent, session.pid, "1", "en", "text", [])
        await study.participants.move(tx, session, "input-check")
        await study.units.form(tx, [session])
        await study.participants.arrive(tx, "PBBBBBB", "en", "link")  # and is still undecided
    unit = study.units.of(session)
    assert unit is not None and session.record.step == "practice"
    return tx, session, unit


@pytest.mark.parametrize("change", CHANGES)
def test_a_transaction_that_has_ended_raises_and_changes_nothing(tmp_path: Path, change: str) -> None:
    async def test(study: RunningStudy) -> None:
        stale, session, unit = await at_practice(study)
        before = (session.record, list(study.units), list(study.participants), study.progress.paused, unit.problem)
        rows = study.databases.store.rows(participants)
        with pytest.raises(RuntimeError, match="this transaction has ended"):
            result = CHANGES[change](study, stale, session, unit)
            if inspect.isawaitable(result):
                await result
        after = (session.record, list(study.units), list(study.participants), study.progress.paused, unit.problem)
        assert (after, study.databases.store.rows(participants)) == (before, rows)

    run(tmp_path, test)


def test_the_second_transaction_begins_when_the_first_has_ended(tmp_path: Path) -> None:
    async def test(study: RunningStudy) -> None:
        order = []

        async def change(name: str) -> None:
            async with study.transaction() as tx:
                order.append(f"{name} begins")
                await tx.run(study.databases.store.everybody)
                await asyncio.sleep(0)
                order.append(f"{name} ends")

        await asyncio.gather(change("first"), change("second"))
        assert order == ["first begins", "first ends", "second begins", "second ends"]

    run(tmp_path, test)


def test_while_somebodys_change_takes_long_others_are_shown_their_page_and_answers_are_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Changes queue; while a room of one opens slowly, nobody's view or answer waits for it."""

    async def test(study: RunningStudy) -> None:
        _, session, unit = await at_practice(study)
        opening, goes_on, order = asyncio.Event(), asyncio.Event(), list[str]()
        actions, views = ParticipantActions(study), ParticipantViews(study)
        really = study.host.open_room

        async def open_slowly(*given: Any) -> str:
            opening.set()
            await goes_on.wait()
            return await really(*given)

        async def note(name: str, work: Awaitable[object]) -> None:
            await work
            order.append(name)

        async with study.transaction() as tx:
            other = await study.participants.arrive(tx, "PCCCCCC", "en", "link")
            await tx.run(study.databases.store.consent, other.pid, "1", "en", "text", [])
            await study.participants.move(tx, other, "form")
        item = study.study.questionnaire("demographics", "en").items[0]
        answer = StudyAnswerRequest("form", item.id, 0)
        monkeypatch.setattr(study.host, "open_room", open_slowly)
        async with asyncio.timeout(WAIT_S), asyncio.TaskGroup() as tasks:
            tasks.create_task(note("opened", open_room(study, unit, session)))
            await opening.wait()
            tasks.create_task(note("stop", actions.stop(other, True)))
            await note("view", views.view(other))
            await note("answer", actions.answer(other, answer))
            goes_on.set()
        assert order[:2] == ["view", "answer"] and {*order[2:]} == {"opened", "stop"}

    async def open_room(study: RunningStudy, unit: StudyUnit, session: ParticipantSession) -> None:
        async with study.transaction() as tx:
            step = session.step
            assert step is not None
            await study.rooms.open(tx, unit, step)

    run(tmp_path, test)


def test_a_transaction_ends_with_an_error_too_and_lets_the_next_one_begin(tmp_path: Path) -> None:
    async def test(study: RunningStudy) -> None:
        with pytest.raises(ZeroDivisionError):
            async with study.transaction() as tx:
                raise ZeroDivisionError
        with pytest.raises(RuntimeError, match="ended"):
            tx.check()
        async with study.transaction() as another:
            another.check()

    run(tmp_path, test)


def test_nothing_changes_while_another_server_may_run_the_study(tmp_path: Path) -> None:
    async def test() -> None:
        in_charge = True
        folder = StudyFolder(parse_study(SOLO), tmp_path)
        study = RunningStudy(folder, SOLO, Host(Settings(data=tmp_path)), Admission(), in_charge=lambda: in_charge)
        try:
            _, session, unit = await at_practice(study)
            in_charge = False
            assert study.is_over()
            async with study.transaction() as tx:
                with pytest.raises(StoreFenced):
                    await study.participants.move(tx, session, "debrief")
                with pytest.raises(StoreFenced):
                    await study.rooms.open(tx, unit, session.steps[3])
            assert session.record.step == "practice"
        finally:
            study.databases.close()

    asyncio.run(test())
