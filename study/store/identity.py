"""The identities of participants, separate from all other data. Deleting this database makes the data anonymous."""

import json
import secrets
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from sqlalchemy import delete, insert, make_url, select, update
from sqlalchemy.exc import ArgumentError

from movingout.study.errors import StudyError
from movingout.study.store.clock import now_ms
from movingout.study.store.database import Database
from movingout.study.store.tables import identities

IDENTITIES = "movingout_identities"  # the schema of identities, where they have no database of their own
CODE = "code"  # source of who has a code of the experimenter, which is good for nothing once it is deleted
UNMISTAKABLE = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"  # nothing that is misread
NO_PARAMETERS = json.dumps({})
_PID_LENGTH = 6


def identities_in(database: str) -> str:
    """The address of identities beside the data: a schema of their own in the same database. Raises StudyError."""
    try:
        url = make_url(database).update_query_dict({"options": f"-csearch_path={IDENTITIES}"})
    except (ArgumentError, ValueError):
        problem = f"{database!r} is no address of a database; it looks like postgresql://user@host/name"
        raise StudyError(problem) from None
    return url.render_as_string(hide_password=False)


class Leftover(NamedTuple):
    """An identity of nobody who takes part: of a visitor who has gone, or a code."""

    pid: str
    source: str
    at_ms: int  # when it was first seen, in ms since the epoch; of a code, when it was made
    used: bool  # whether a browser came with it

    @property
    def half_arrived(self) -> bool:
        """Whether they have got no page yet, and so were written down nowhere else: it is the last step of arriving."""
        return self.source != CODE and not self.used


class IdentityStore:
    """Recruitment ids and the pseudonyms that stand for them everywhere else."""

    def __init__(self, address: Path | str, now: Callable[[], int] = now_ms, fence: int = 0) -> None:
        self.database = Database(address, "identity", fence)
        self._now = now

    def pid(self, source: str, external_id: str, parameters: Mapping[str, str] | None = None) -> tuple[str, bool]:
        """The pseudonym of a recruitment id, and whether it is new; returning participants keep theirs."""
        with self.database.write() as connection:
            known = select(identities.c.pid).where(
                identities.c.source == source, identities.c.external_id == external_id
            )
            found = connection.execute(known).scalar()
            if found is not None:
                return str(found), False
            pid = new_pid()
            row = {"source": source, "external_id": external_id, "parameters": json.dumps(dict(parameters or {}))}
            connection.execute(insert(identities).values(pid=pid, at_ms=self._now(), **row))
            return pid, True

    def external(self, pid: str) -> tuple[str, str] | None:
        """Source and id of a participant, to pay them; None when it was deleted or never given."""
        with self.database.read() as connection:
            query = select(identities.c.source, identities.c.external_id).where(identities.c.pid == pid)
            row = connection.execute(query).one_or_none()
            return (str(row.source), str(row.external_id)) if row else None

    def known(self, source: str, external_id: str) -> str | None:
        """The pseudonym of a recruitment id that is already known, else None."""
        with self.database.read() as connection:
            query = select(identities.c.pid).where(
                identities.c.source == source, identities.c.external_id == external_id
            )
            found = connection.execute(query).scalar()
            return None if found is None else str(found)

    def pids(self, external_id: str) -> list[str]:
        """The pseudonyms of a recruitment id, whatever its source: nearly always one, or none."""
        with self.database.read() as connection:
            query = select(identities.c.pid).where(identities.c.external_id == external_id)
            return [str(pid) for pid in connection.execute(query).scalars()]

    def open_session(self, pid: str, token_hash: str) -> None:
        """From now on only the browser with this secret acts for the participant."""
        with self.database.write() as connection:
            connection.execute(update(identities).where(identities.c.pid == pid).values(token=token_hash))

    def of_session(self, token_hash: str) -> str | None:
        """The participant that a secret belongs to."""
        with self.database.read() as connection:
            found = connection.execute(select(identities.c.pid).where(identities.c.token == token_hash)).scalar()
            return None if found is None else str(found)

    def everybody(self) -> dict[str, tuple[str, str]]:
        """Source and id by pseudonym."""
        with self.database.read() as connection:
            rows = connection.execute(select(identities.c.pid, identities.c.source, identities.c.external_id))
            return {str(row.pid): (str(row.source), str(row.external_id)) for row in rows}

    def without(self, pids: Collection[str]) -> list[Leftover]:
        """The identities but those of these participants."""
        columns = (identities.c.pid, identities.c.source, identities.c.at_ms, identities.c.token.is_not(None))
        with self.database.read() as connection:
            return [Leftover(*row) for row in connection.execute(select(*columns)) if row.pid not in pids]

    def parameters(self) -> dict[str, dict[str, str]]:
        """By pseudonym, what else their link said, such as the assignment that is to be paid."""
        with self.database.read() as connection:
            rows = connection.execute(select(identities.c.pid, identities.c.parameters))
            return {str(row.pid): dict(json.loads(row.parameters)) for row in rows}

    def keep_parameters(self, pid: str, parameters: Mapping[str, str]) -> None:
        """What the newest link of a participant said."""
        change = update(identities).where(identities.c.pid == pid)
        with self.database.write() as connection:
            connection.execute(change.values(parameters=json.dumps(dict(parameters))))

    def drop(self, pids: Sequence[str]) -> None:
        """Delete people who did not consent; `Database.scrub` overwrites them, which is dear, for many at once."""
        if not pids:
            return
        with self.database.write() as connection:
            self.database.mark_deleted(connection)
            connection.execute(delete(identities).where(identities.c.pid.in_(pids)))

    def drop_visitors(self, pids: Sequence[str]) -> None:
        """Delete people who opened a link and did not consent, whom it makes known anew.

        A code is the experimenter's, and stays good; of who came with it nothing is kept.
        """
        if not pids:
            return
        chosen, coded = identities.c.pid.in_(pids), identities.c.source == CODE
        used = identities.c.token.is_not(None) | (identities.c.parameters != NO_PARAMETERS)
        cleared = update(identities).values(token=None, parameters=NO_PARAMETERS)
        with self.database.write() as connection:
            gone = connection.execute(delete(identities).where(chosen, ~coded)).rowcount
            if gone + connection.execute(cleared.where(chosen, coded, used)).rowcount:
                self.database.mark_deleted(connection)

    def forget(self, pid: str) -> int:
        """Delete a participant; returns the number of rows."""
        with self.database.write() as connection:
            self.database.mark_deleted(connection)
            removed = connection.execute(delete(identities).where(identities.c.pid == pid)).rowcount
        self.database.scrub()
        return int(removed)

    def close(self) -> None:
        self.database.close()


def new_pid() -> str:
    """A random pseudonym: P and six letters or digits."""
    return "P" + "".join(secrets.choice(UNMISTAKABLE) for _ in range(_PID_LENGTH))
