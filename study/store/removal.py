"""Deletes the rows of a participant; a tombstone says how many there were."""

from collections.abc import Sequence

from sqlalchemy import ColumnElement, Connection, Table, delete, insert, or_, select, update

from movingout.study.errors import StudyError
from movingout.study.store.audit import record, subject_of
from movingout.study.store.store import Store
from movingout.study.store.tables import answers, consents, notes, participants, players, rounds, tombstones, units


def episodes_of(store: Store, pid: str) -> tuple[str, ...]:
    """The recordings in which a participant plays. Raises StudyError for an unknown one."""
    unit = store.participant(pid).unit
    if unit is None:
        return ()
    with store.database.read() as connection:
        return tuple(connection.execute(select(rounds.c.episode).where(rounds.c.unit == unit)).scalars())


def remove_participant(store: Store, pid: str, recordings: int) -> int:
    """Delete everything about a participant; returns the number of rows.

    The rounds of a pair are deleted for both, as the consent says; the partner's answers stay.
    """
    unit = store.participant(pid).unit
    with store.database.write() as connection:
        subject = subject_of(connection, pid)
        rows = _rows(connection, pid, unit)
        values = {"subject": subject, "at_ms": store.now(), "rows": rows, "recordings": recordings}
        connection.execute(insert(tombstones).values(**values))
        record(connection, store.now(), "experimenter", "forget", pid, rows=rows, recordings=recordings)
    store.database.scrub()
    return rows


def has_data(store: Store, pid: str) -> bool:
    """Whether there are still answers or rounds of a participant, or notes about them."""
    unit = store.participant(pid).unit
    mine = select(answers.c.id).where(answers.c.pid == pid)
    played = select(rounds.c.id).where(rounds.c.unit == unit)
    noted = select(notes.c.id).where(_about(pid, unit))
    with store.database.read() as connection:
        return any(connection.execute(query).first() is not None for query in (mine, played, noted))


def withdraw_data(store: Store, pid: str, recordings: int) -> int:
    """Delete the data of a participant who asked for it; returns the number of rows.

    Their consent and code stay, because they are paid for their time. Does nothing where no data are left.
    """
    unit = store.participant(pid).unit
    with store.database.write() as connection:
        rows = _remove_data(connection, pid, unit)
        if rows or recordings:
            record(connection, store.now(), "participant", "withdraw", pid, rows=rows, recordings=recordings)
    if rows:
        store.database.scrub()
    return rows


def is_erased(store: Store, pid: str) -> bool:
    """Whether there is a tombstone for a participant."""
    with store.database.read() as connection:
        query = select(tombstones.c.subject).where(tombstones.c.subject == subject_of(connection, pid))
        return connection.execute(query).first() is not None


def drop_undecided(store: Store, pids: Sequence[str]) -> None:
    """Delete people who opened the link and never said whether they consent; nothing of them is kept."""
    with store.database.write() as connection:
        consented = select(consents.c.pid)
        chosen = participants.c.pid.in_(pids) & participants.c.pid.not_in(consented)
        connection.execute(delete(participants).where(chosen))


def undecided(store: Store) -> set[str]:
    """Those who have not said whether they consent, and would be forgotten: they do not take part yet."""
    on_their_way = select(participants.c.pid).where(participants.c.code.is_(None))
    with store.database.read() as connection:
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
        connection.execute(update(units).where(units.c.id == unit).values(state="dropped"))
    rows += _remove(connection, notes, _about(pid, unit))
    return rows + _remove(connection, answers, answers.c.pid == pid)


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
