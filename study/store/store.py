"""Everything that happens in a study, written before anybody is told that it is saved.

Every method is one transaction and waits for the disk, so a server calls it in a thread. Raises StoreError when the
database refuses, StudyError for what is not allowed, such as a round without consent.
"""

import json
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from sqlalchemy import BigInteger, Connection, Row, Table, bindparam, func, insert, select, update

from movingout.study.design.allocation import next_slot
from movingout.study.design.definition import Outcome
from movingout.study.errors import StoreError, StudyError
from movingout.study.store.audit import Actor, is_recorded, last_refusal, record
from movingout.study.store.clock import now_ms
from movingout.study.store.database import Database
from movingout.study.store.tables import answers, audit, consents, metadata, notes, participants, study, units

MOST_CHANGES = 200  # answers kept of one step with every change; then a change overwrites the one before


class GivenAnswer(NamedTuple):
    """The newest answer to an item."""

    value: int
    text: str
    at_ms: int


@dataclass(frozen=True, slots=True)
class Unit:
    """A participant, or a pair, with their slot."""

    id: int
    slot: int
    pids: tuple[str, ...]
    paused: bool  # by the experimenter
    dropped: bool = False  # somebody has left it or was removed; its slot is given again


@dataclass(frozen=True, slots=True)
class Participant:
    """A participant and the step they are at."""

    pid: str
    unit: int | None
    member: int
    language: str
    step: str  # key of the step
    arrived_ms: int
    finished_ms: int | None
    outcome: str | None
    code: str | None
    keep: bool | None  # whether the data may be kept, None while nobody has asked
    screen: str  # the same for two who share one screen, else empty
    away_ms: int  # long absences after which they came back
    last_seen_ms: int | None  # as of the last minute, None before and in data of earlier versions; later after a pause
    heard_ms: int | None  # when a page of theirs was last heard, likewise; no pause moves it


class DoneUnit(NamedTuple):
    """A unit all of whose members have finished."""

    id: int
    slot: int
    size: int  # how many people


def planned_done(done: Sequence[DoneUnit], planned: int, group: int) -> int:
    """How many of the planned slots are done, by whole units.

    Earlier versions gave such slots to those with an agent in a partner's place, too; a pair beyond the plan counts for
    each of these.
    """
    whole = [one.slot < planned for one in done if one.size == group]
    alone = [one.slot < planned for one in done if one.size < group]
    return sum(whole) + min(whole.count(False), sum(alone))


class Store:
    """The database of one study."""

    def __init__(self, address: Path | str, now: Callable[[], int] = now_ms, fence: int = 0) -> None:
        self.database = Database(address, "main", fence)
        self.now = now

    def close(self) -> None:
        self.database.close()

    def pause(self, paused: bool, unit: int | None = None) -> None:
        """Stop or resume the clock of a unit, or of everybody."""
        change = update(study) if unit is None else update(units).where(units.c.id == unit)
        with self.database.write() as connection:
            connection.execute(change.values(paused=paused))

    def paused(self) -> bool:
        """Whether the experimenter has stopped everybody's clock."""
        with self.database.read() as connection:
            return bool(connection.execute(select(study.c.paused)).scalar_one())

    # ---- participants -----------------------------------------------------------------------------------------------

    def arrive(self, pid: str, language: str, step: str = "consent") -> Participant:
        """A participant opens the link, for the first time or again; returns where they are."""
        with self.database.write() as connection:
            known = connection.execute(select(participants.c.pid).where(participants.c.pid == pid)).first()
            if known is None:
                row = {"pid": pid, "member": 0, "language": language, "step": step, "arrived_ms": self.now()}
                connection.execute(insert(participants).values(**row))
            return _participant(connection, pid)

    def participant(self, pid: str) -> Participant:
        """Raises StudyError for an unknown pseudonym."""
        with self.database.read() as connection:
            return _participant(connection, pid)

    def everybody(self) -> tuple[Participant, ...]:
        """All participants in order of arrival."""
        with self.database.read() as connection:
            rows = connection.execute(select(participants).order_by(participants.c.arrived_ms, participants.c.pid))
            return tuple(_of_row(row) for row in rows)

    def move(self, pid: str, step: str) -> None:
        """The participant is now at this step."""
        self._change(pid, step=step)

    def set_language(self, pid: str, language: str) -> None:
        """The participant reads in this language from now on."""
        self._change(pid, language=language)

    def set_shared_screen(self, pids: Sequence[str], screen: str) -> None:
        """Note that these share one screen and will play with each other."""
        with self.database.write() as connection:
            connection.execute(update(participants).where(participants.c.pid.in_(pids)).values(screen=screen))

    def consent(self, pid: str, version: str, language: str, shown: str, boxes: Sequence[str]) -> None:
        """Store a consent with the hash of the exact text that was shown."""
        digest = sha256(shown.encode()).hexdigest()
        with self.database.write() as connection:
            known = _participant(connection, pid)
            if not is_recorded(connection, "arrive", pid):  # earlier versions did so at once
                # only now, because the audit forgets nothing: of those who do not consent nothing is kept
                record(connection, known.arrived_ms, "participant", "arrive", pid)
            row = {"pid": pid, "version": version, "language": language, "sha256": digest, "given_ms": self.now()}
            connection.execute(insert(consents).values(**row, boxes=json.dumps(list(boxes))))
            record(connection, self.now(), "participant", "consent", pid, version=version, sha256=digest)

    def has_consented(self, pid: str, version: str) -> bool:
        with self.database.read() as connection:
            query = select(consents.c.id).where(consents.c.pid == pid, consents.c.version == version)
            return connection.execute(query).first() is not None

    def finish(self, pid: str, outcome: Outcome, code: str, away_s: float = 0.0) -> str:
        """Finish a participant and return their code. The first outcome stands; asking again gives the same code.

        Their time ends now, or `away_s` seconds ago: pay for the minutes here does not grow while they are away.
        """
        with self.database.write() as connection:
            known = _participant(connection, pid)
            if known.code is not None:
                return known.code
            change = update(participants).where(participants.c.pid == pid)
            ended = max(known.arrived_ms, self.now() - round(1e3 * away_s))
            connection.execute(change.values(finished_ms=ended, outcome=outcome, code=code, step="code"))
            record(connection, self.now(), "participant", "finish", pid, outcome=outcome)
            if known.unit is not None:
                _settle(connection, known.unit)
            return code

    def was_away(self, pid: str, away_s: float) -> None:
        """A participant came back after so many seconds, for which they are not paid."""
        with self.database.write() as connection:
            change = update(participants).where(participants.c.pid == pid)
            connection.execute(change.values(away_ms=participants.c.away_ms + round(1e3 * away_s)))

    def seen(self, last_seen_ms: Mapping[str, int], heard: Collection[str] = ()) -> None:
        """When participants were last seen, by pseudonym, and which of them have been heard from by now."""
        now = self.now()
        rows = [{"who": pid, "at": at, "heard": now if pid in heard else None} for pid, at in last_seen_ms.items()]
        heard_ms = func.coalesce(bindparam("heard", type_=BigInteger), participants.c.heard_ms)
        change = update(participants).where(participants.c.pid == bindparam("who"))
        with self.database.write() as connection:
            connection.execute(change.values(last_seen_ms=bindparam("at"), heard_ms=heard_ms), rows)

    def set_back(self, by_ms: Mapping[str, int]) -> None:
        """The clock was set back: participants, by pseudonym, arrived so many milliseconds earlier and are here now."""
        change = update(participants).where(participants.c.pid == bindparam("who"))
        moved = {name: participants.c[name] - bindparam("by") for name in ("arrived_ms", "heard_ms")}
        with self.database.write() as connection:
            here = change.values(**moved, last_seen_ms=self.now())
            connection.execute(here, [{"who": pid, "by": by} for pid, by in by_ms.items()])
            seconds = round(max(by_ms.values()) / 1e3)
            record(connection, self.now(), "server", "clock-set-back", participants=len(by_ms), seconds=seconds)

    def keep_data(self, pid: str, keep: bool) -> None:
        """The answer to "may we keep your data?"."""
        self._change(pid, keep=keep)

    def _change(self, pid: str, **values: object) -> None:
        with self.database.write() as connection:
            _participant(connection, pid)
            connection.execute(update(participants).where(participants.c.pid == pid).values(**values))

    # ---- units ------------------------------------------------------------------------------------------------------

    def form_unit(self, pids: Sequence[str], first_slot: int = 0) -> Unit:
        """Give a participant or a pair the lowest free slot from `first_slot` on; whoever has one keeps it."""
        with self.database.write() as connection:
            known = [_participant(connection, pid) for pid in pids]
            if known[0].unit is not None and len({one.unit for one in known}) == 1:
                return _unit(connection, known[0].unit)
            taken = [one.pid for one in known if one.unit is not None]
            if taken:
                raise StudyError(f"{', '.join(taken)} plays in another pair already")
            if connection.dialect.name == "postgresql":
                connection.exec_driver_sql("LOCK TABLE units IN EXCLUSIVE MODE")  # two servers, one lowest slot
            held = connection.execute(select(units.c.slot).where(units.c.state != "dropped")).scalars().all()
            row = {"slot": next_slot(set(held), first_slot), "state": "active", "formed_ms": self.now()}
            number = connection.execute(insert(units).values(**row).returning(units.c.id)).scalar_one()
            for member, pid in enumerate(pids):
                change = update(participants).where(participants.c.pid == pid)
                connection.execute(change.values(unit=number, member=member))
                record(connection, self.now(), "server", "allocate", pid, unit=number, slot=row["slot"])
            return _unit(connection, number)

    def units_on_their_way(self) -> tuple[Unit, ...]:
        """Units with a member who has not finished, even where the partner has left."""
        on_their_way = participants.c.unit.is_not(None) & participants.c.code.is_(None)
        with self.database.read() as connection:
            numbers = connection.execute(select(participants.c.unit).where(on_their_way).distinct()).scalars().all()
            return tuple(_unit(connection, number) for number in sorted(numbers))

    def done_units(self) -> tuple[DoneUnit, ...]:
        """Units all of whose members have finished, of whom nobody has left and nobody's data were removed.

        Those whose data were removed because their retention period was over are among them.
        """
        members = select(units.c.id, units.c.slot, func.count()).join(participants, participants.c.unit == units.c.id)
        query = members.where(units.c.state == "done").group_by(units.c.id, units.c.slot)
        with self.database.read() as connection:
            done = [DoneUnit(*row) for row in connection.execute(query)]
            return (*done, *_purged_units(connection))

    # ---- answers and notes ---------------------------------------------------------------------------------------

    def answer(
        self,
        pid: str,
        step: str,
        questionnaire: str,
        partner: str,
        item: str,
        value: int,
        text: str,
        elapsed_ms: float,
        hidden_ms: float = 0.0,
    ) -> None:
        """Store one click, once however often it is sent: its response may have been lost with a server.

        A changed answer is another row, up to MOST_CHANGES of a step; the newest counts.
        """
        row: dict[str, Any] = {
            "pid": pid,
            "step": step,
            "questionnaire": questionnaire,
            "partner": partner,
            "item": item,
        }
        row |= {"value": value, "text": text, "elapsed_ms": elapsed_ms, "hidden_ms": hidden_ms, "at_ms": self.now()}
        with self.database.write() as connection:
            if not connection.execute(select(consents.c.id).where(consents.c.pid == pid)).first():
                raise StudyError("nothing is kept before the consent is given")
            if _is_repeated(connection, row):
                return
            newest = _newest_of_many(connection, pid, step, item)
            if newest is None:
                connection.execute(insert(answers).values(**row))
            else:
                connection.execute(update(answers).where(answers.c.id == newest).values(**row))

    def answers(self, pid: str, step: str) -> dict[str, GivenAnswer]:
        """The newest answer per item of a step."""
        query = select(answers).where(answers.c.pid == pid, answers.c.step == step).order_by(answers.c.id)
        with self.database.read() as connection:
            return {row.item: GivenAnswer(row.value, row.text, row.at_ms) for row in connection.execute(query)}

    def note(self, text: str, unit: int | None = None) -> None:
        """Store a note of the experimenter."""
        with self.database.write() as connection:
            connection.execute(insert(notes).values(unit=unit, text=text, at_ms=self.now()))

    def audit(self, actor: Actor, action: str, pid: str = "", **detail: object) -> None:
        """Add a row to the audit for something that happened elsewhere, such as an export."""
        with self.database.write() as connection:
            record(connection, self.now(), actor, action, pid, **detail)

    def refusal(self, pid: str) -> str:
        """Why a participant last did not pass the input check; empty where nothing refused them."""
        with self.database.read() as connection:
            return last_refusal(connection, pid)

    def rows(self, table: Table) -> list[dict[str, Any]]:
        """All rows of a table, ordered by key."""
        with self.database.read() as connection:
            found = connection.execute(select(table).order_by(*table.primary_key.columns))
            return [dict(row) for row in found.mappings()]

    def tables(self) -> dict[str, Table]:
        return dict(metadata.tables)


def _newest_of_many(connection: Connection, pid: str, step: str, item: str) -> int | None:
    """The row of this answer that a new one overwrites, once there are MOST_CHANGES rows of the step."""
    mine = (answers.c.pid == pid) & (answers.c.step == step)
    if connection.execute(select(func.count()).select_from(answers).where(mine)).scalar_one() < MOST_CHANGES:
        return None
    newest: int | None = connection.execute(select(func.max(answers.c.id)).where(mine, answers.c.item == item)).scalar()
    return newest


def _is_repeated(connection: Connection, row: Mapping[str, Any]) -> bool:
    """Whether the newest answer to the item is this very click."""
    mine = [answers.c[name] == row[name] for name in ("pid", "step", "item")]
    newest = connection.execute(select(answers).where(*mine).order_by(answers.c.id.desc()).limit(1)).one_or_none()
    return newest is not None and all(
        getattr(newest, name) == row[name] for name in ("value", "text", "elapsed_ms", "hidden_ms")
    )


def _participant(connection: Connection, pid: str) -> Participant:
    row = connection.execute(select(participants).where(participants.c.pid == pid)).one_or_none()
    if row is None:
        raise StudyError(f"there is no participant {pid!r}")
    return _of_row(row)


def _of_row(row: Row[Any]) -> Participant:
    return Participant(*(getattr(row, name) for name in Participant.__slots__))


def _unit(connection: Connection, number: int) -> Unit:
    row = connection.execute(select(units).where(units.c.id == number)).one_or_none()
    if row is None:
        raise StoreError(f"there is no unit {number}")
    members = select(participants.c.pid).where(participants.c.unit == number).order_by(participants.c.member)
    pids = tuple(connection.execute(members).scalars())
    return Unit(row.id, row.slot, pids, row.paused, dropped=row.state == "dropped")


def _purged_units(connection: Connection) -> list[DoneUnit]:
    """Each with its original size, from the audit: the rows of their members are deleted."""
    slots = {row.id: row.slot for row in connection.execute(select(units).where(units.c.state == "purged"))}
    if not slots:
        return []
    noted = connection.execute(select(audit.c.detail).where(audit.c.action == "allocate")).scalars()
    sizes = Counter(json.loads(detail)["unit"] for detail in noted)
    return [DoneUnit(unit, slot, sizes[unit]) for unit, slot in slots.items()]


def _settle(connection: Connection, number: int) -> None:
    """A unit is done when all its members are, and dropped when one left for another reason."""
    outcomes = connection.execute(select(participants.c.outcome).where(participants.c.unit == number)).scalars().all()
    left = any(outcome not in (None, "done") for outcome in outcomes)
    state = "dropped" if left else "done" if all(outcomes) else "active"
    connection.execute(update(units).where(units.c.id == number, units.c.state == "active").values(state=state))
