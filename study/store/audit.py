"""The audit: who did what, and when. Rows are only ever added, in the transaction that they describe."""

import json
from hashlib import sha256
from typing import Literal

from sqlalchemy import Connection, insert, select

from movingout.study.store.tables import audit, study

Actor = Literal["participant", "experimenter", "server"]


def record(connection: Connection, at_ms: int, actor: Actor, action: str, pid: str = "", **detail: object) -> None:
    """Add a row. `detail` names no participant."""
    subject = subject_of(connection, pid) if pid else ""
    text = json.dumps(detail, ensure_ascii=False, sort_keys=True)
    connection.execute(insert(audit).values(at_ms=at_ms, actor=actor, action=action, subject=subject, detail=text))


def is_recorded(connection: Connection, action: str, pid: str) -> bool:
    """Whether there is a row of this action for a participant."""
    same = (audit.c.action == action) & (audit.c.subject == subject_of(connection, pid))
    return connection.execute(select(audit.c.id).where(same)).first() is not None


def last_refusal(connection: Connection, pid: str) -> str:
    """Why a participant last did not pass the input check, be it before a restart; empty where nothing did."""
    mine = (audit.c.action == "refused") & (audit.c.subject == subject_of(connection, pid))
    detail = connection.execute(select(audit.c.detail).where(mine).order_by(audit.c.id.desc())).scalars().first()
    return str(json.loads(detail)["why"]) if detail else ""


def subject_of(connection: Connection, pid: str) -> str:
    """The hash that stands for a participant in the audit and on a tombstone."""
    salt = connection.execute(select(study.c.salt)).scalar_one()
    return sha256(f"{salt} {pid}".encode()).hexdigest()[:16]
