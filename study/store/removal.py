"""Deletes the rows of a participant; a tombstone says how many there were."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from sqlalchemy import ColumnElement, Connection, Table, delete, exists, insert, or_, select, update
from sqlalchemy.dialects import postgresql, sqlite

from movingout.study.errors import StudyError
from movingout.study.store.audit import record, subject_of
from movingout.study.store.store import Store
from movingout.study.store.tables import (
    answers,
    consents,
    counts,
    notes,
    participants,
    players,
    rounds,
    tombstones,
    units,
)

MOST_AT_ONCE = 5000  # participants whom one query names
UNDECIDED_S = 1800.0  # how long somebody who has not consented yet may be away

Forget = Callable[[Sequence[str]], object]
"""Deletes the identities of these pseudonyms. It comes first: a kill in between leaves a row here that is found again,
not an id of nobody."""


def no_identities(pids: Sequence[str]) -> None:
    """Where there are none to forget."""


def episodes_of(store: Store, pid: str) -> tuple[str, ...]:
    """The recordings in which a participant plays. Raises StudyError for an unknown one."""
    unit = store.participant(pid).unit
    if unit is None:
        return ()
    with store.database.read() as connection:
        return tuple(connection.execute(select(rounds.c.episode).where(rounds.c.unit == unit)).scalars())


def remove_participant(store: Store, pid: str, recordings: int, expired: bool = False) -> int:
    """Delete everything about a participant; returns the number of rows.

    The rounds of a pair are deleted for both, as the consent says; the partner's answers stay. Where only the time to
    keep them has `expired`, the slot of a unit that is done stays done.
    """
    unit = store.participant(pid).unit
    with store.database.write() as connection:
        store.database.mark_deleted(connection)
        subject = subject_of(connection, pid)
        if expired and unit is not None:
            _note_purge(connection, unit)
        rows = _rows(connection, pid, unit)
        values = {"subject": subject, "at_ms": store.now(), "rows": rows, "recordings": recordings}
        connection.execute(insert(tombstones).values(**values))
        record(connection, store.now(), "experimenter", "forget", pid, rows=rows, recordings=recordings)
    store.database.scrub()
    return rows


def rounds_by_participant(store: Store, pids: Sequence[str]) -> dict[str, list[dict[str, Any]]]:
    """The rounds of those among these participants who have a unit, which may be none: nobody plays without."""
    found: dict[str, list[dict[str, Any]]] = {}
    with store.database.read() as connection:
        for some in _parts(pids):
            with_unit = select(participants.c.pid).where(participants.c.pid.in_(some), participants.c.unit.is_not(None))
            found |= {str(pid): [] for pid in connection.execute(with_unit).scalars()}
            played = select(participants.c.pid.label("_pid"), *rounds.c).join_from(
                participants, rounds, participants.c.unit == rounds.c.unit
            )
            for row in connection.execute(played.where(participants.c.pid.in_(some))).mappings():
                found[row["_pid"]].append(dict(row))
    return found


def with_data(store: Store, pids: Sequence[str]) -> set[str]:
    """Those of them of whom there are still answers, rounds, a slot or notes about them."""
    found: set[str] = set()
    mine = exists().where(answers.c.pid == participants.c.pid)
    played = exists().where(rounds.c.unit == participants.c.unit)
    noted = exists().where(notes.c.unit == participants.c.unit)
    holding = exists().where(units.c.id == participants.c.unit, units.c.state.not_in(("dropped", "purged")))
    with store.database.read() as connection:
        for some in _parts(pids):
            query = select(participants.c.pid).where(participants.c.pid.in_(some), or_(mine, played, noted, holding))
            found |= {str(pid) for pid in connection.execute(query).scalars()}
        texts = "\n".join(connection.execute(select(notes.c.text)).scalars())
    return found | {pid for pid in pids if pid in texts}


def withdraw_data(store: Store, recordings: Mapping[str, int]) -> int:
    """Delete the data of participants who asked for it; returns the number of rows. `Database.scrub` overwrites them.

    `recordings` says by pseudonym how many were deleted before. Consents and codes stay, because they are paid for
    their time. Does nothing where no data are left.
    """
    left = with_data(store, [*recordings])
    pids = [pid for pid, number in recordings.items() if number or pid in left]
    return _withdraw(store, {pid: recordings[pid] for pid in pids}) if pids else 0


def _withdraw(store: Store, recordings: Mapping[str, int]) -> int:
    whole = 0
    with store.database.write() as connection:
        for pid, number in recordings.items():
            unit = connection.execute(select(participants.c.unit).where(participants.c.pid == pid)).scalar()
            rows = _remove_data(connection, pid, unit)
            if rows or number:
                record(connection, store.now(), "participant", "withdraw", pid, rows=rows, recordings=number)
            whole += rows
        if whole:
            store.database.mark_deleted(connection)
    return whole


def _parts(pids: Sequence[str]) -> Iterator[Sequence[str]]:
    """So many at a time as a query may name."""
    return (pids[start : start + MOST_AT_ONCE] for start in range(0, len(pids), MOST_AT_ONCE))


def is_erased(store: Store, pid: str) -> bool:
    """Whether there is a tombstone for a participant."""
    with store.database.read() as connection:
        query = select(tombstones.c.subject).where(tombstones.c.subject == subject_of(connection, pid))
        return connection.execute(query).first() is not None


def decline(store: Store, pid: str, forget: Forget = no_identities) -> None:
    """A participant does not consent: only the count of such people is kept. Raises StudyError after a consent."""
    with store.database.write() as connection:
        if connection.execute(select(consents.c.id).where(consents.c.pid == pid)).first():
            raise StudyError("consent was given already; to leave, stop the study and choose whether the data are kept")
        remove_undecided(store, connection, [pid], forget)
        kind = sqlite if connection.dialect.name == "sqlite" else postgresql
        added = kind.insert(counts).values(name="declined", number=1)
        connection.execute(added.on_conflict_do_update(index_elements=["name"], set_={"number": counts.c.number + 1}))


def drop_undecided(store: Store, pids: Sequence[str], forget: Forget = no_identities) -> set[str]:
    """Delete people who opened the link and never said whether they consent; nothing of them is kept.

    Returns those of them who stay, because they have consented.
    """
    with store.database.write() as connection:
        remove_undecided(store, connection, pids, forget)
        left = select(participants.c.pid).where(participants.c.pid.in_(pids))
        return set(connection.execute(left).scalars())


def remove_undecided(store: Store, connection: Connection, pids: Sequence[str], forget: Forget) -> None:
    """Delete those of them without a consent, and the notes about them, which `Database.scrub` overwrites."""
    chosen = participants.c.pid.in_(pids) & participants.c.pid.not_in(select(consents.c.pid))
    gone = connection.execute(delete(participants).where(chosen).returning(participants.c.pid)).scalars().all()
    forget(gone)
    about = connection.execute(select(notes.c.id, notes.c.text)).all()
    named = [row.id for row in about if any(pid in row.text for pid in gone)]
    if named:
        store.database.mark_deleted(connection)
        _remove(connection, notes, notes.c.id.in_(named))


def undecided(store: Store) -> set[str]:
    """Those who have not said whether they consent, and would be forgotten: they do not take part yet."""
    with store.database.read() as connection:
        return undecided_in(connection)


def undecided_in(connection: Connection) -> set[str]:
    """The same, in a transaction."""
    on_their_way = select(participants.c.pid).where(participants.c.code.is_(None))
    return set(connection.execute(on_their_way.where(participants.c.pid.not_in(select(consents.c.pid)))).scalars())


def _rows(connection: Connection, pid: str, unit: int | None) -> int:
    rows = _remove_data(connection, pid, unit)
    for table in (consents, participants):
        rows += _remove(connection, table, table.c.pid == pid)
    return rows


def _remove_data(connection: Connection, pid: str, unit: int | None) -> int:
    """Answers, rounds and the notes about them, or that name the participant."""
    mine = select(rounds.c.id).where(rounds.c.unit == unit)
    rows = _remove(connection, players, or_(players.c.pid == pid, players.c["round"].in_(mine)))
    if unit is not None:
        rows += _remove(connection, rounds, rounds.c.unit == unit)
        gone = update(units).where(units.c.id == unit, units.c.state != "purged")
        connection.execute(gone.values(state="dropped"))
    rows += _remove(connection, notes, _about(pid, unit))
    return rows + _remove(connection, answers, answers.c.pid == pid)


def _note_purge(connection: Connection, unit: int) -> None:
    """A unit that is done is from now on one whose time is over, unless somebody in it wants their data deleted."""
    unwanted = exists().where(participants.c.unit == unit, participants.c.keep.is_(False))
    done = update(units).where(units.c.id == unit, units.c.state == "done", ~unwanted)
    connection.execute(done.values(state="purged"))


def _about(pid: str, unit: int | None) -> ColumnElement[bool]:
    """The notes on a participant or their unit, which may say who it was."""
    named = notes.c.text.contains(pid, autoescape=True)
    return named if unit is None else or_(named, notes.c.unit == unit)


def _remove(connection: Connection, table: Table, condition: ColumnElement[bool]) -> int:
    return int(connection.execute(delete(table).where(condition)).rowcount)


def called(store: Store, name: str) -> list[str]:
    """Whose pseudonym or completion code this is. Raises StudyError for the pseudonym of one who was deleted."""
    if is_erased(store, name):
        raise StudyError(f"{name} was deleted already; the tombstone says so")
    with store.database.read() as connection:
        query = select(participants.c.pid).where(or_(participants.c.pid == name, participants.c.code == name))
        return [str(pid) for pid in connection.execute(query).scalars()]
