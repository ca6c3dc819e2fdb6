"""What a study is run with: kept before anybody comes, the same once somebody has consented."""

import json
import secrets
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from sqlalchemy import Connection, Row, insert, select, update

from movingout.study.design.definition import ALLOCATION
from movingout.study.errors import StudyError
from movingout.study.store.audit import record
from movingout.study.store.removal import Forget, no_identities, remove_undecided, undecided_in
from movingout.study.store.store import Store
from movingout.study.store.tables import audit, participants, study, units

_FILE = "its file or a text beside it"
MAP = "map:"  # before the name of a map of one's own, among the models


@dataclass(frozen=True, slots=True)
class FrozenStudy:
    """What the study was run with."""

    id: str
    file_text: str
    file_sha256: str
    code: Mapping[str, str]
    models: Mapping[str, str]
    simulated: bool  # whether the participants were programs
    allocation: int  # rule by which its slots are drawn


def freeze_study(
    store: Store,
    id: str,
    file_text: str,
    code: Mapping[str, str],
    models: Mapping[str, str],
    simulated: bool = False,
    forget: Forget = no_identities,
) -> set[str]:
    """Store what the study is run with. It may not change once a participant has consented; before, the newest counts.

    Newer software is allowed, since a bug may have to be fixed in the middle of a study, and is audited.
    Data of `simulated` participants are never mixed with data of people. Raises StudyError where it would change.
    Returns who was asked for their consent before a change, and has not given it: they are deleted, by `forget` their
    identities too, and begin anew, because their page may show what they read then.
    """
    asked = set[str]()
    digest = sha256(file_text.encode()).hexdigest()
    row: dict[str, Any] = {
        "id": id,
        "file_text": file_text,
        "file_sha256": digest,
        "models": json.dumps(dict(models)),
        "simulated": simulated,
        "allocation": ALLOCATION,
    }
    row |= {"code": json.dumps(dict(code)), "frozen_ms": store.now()}
    with store.database.write() as connection:
        known = connection.execute(select(study)).one_or_none()
        if known is None:
            connection.execute(insert(study).values(**row, salt=secrets.token_hex(16)))
        elif not _begun(connection):
            if (known.file_sha256, known.simulated) != (digest, simulated):
                asked = undecided_in(connection)
                remove_undecided(store, connection, [*asked], forget)
            connection.execute(update(study).values(**row))
        else:
            _check_same(store, connection, known, row)
            return asked
        record(connection, store.now(), "server", "freeze", file_sha256=digest, models=dict(models), code=dict(code))
    return asked


def frozen_study(store: Store) -> FrozenStudy:
    """Raises StudyError for a database in which no study was run."""
    with store.database.read() as connection:
        row = connection.execute(select(study)).one_or_none()
    if row is None:
        raise StudyError("nothing was recorded here yet: the study has not been run in this --data folder")
    return FrozenStudy(
        row.id,
        row.file_text,
        row.file_sha256,
        code=json.loads(row.code),
        models=json.loads(row.models),
        simulated=row.simulated,
        allocation=row.allocation,
    )


def code_by_time(store: Store) -> list[dict[str, Any]]:
    """The software that the study was run with, and from when (`from_ms`), in order.

    `code` is None where an earlier version did not note what was there before newer software. Raises StudyError.
    """
    last = frozen_study(store).code
    noted = [row for row in store.rows(audit) if row["action"] in ("freeze", "code")]
    begins = max((at for at, row in enumerate(noted) if row["action"] == "freeze"), default=0)
    details = [json.loads(row["detail"]) for row in noted[begins:]]
    first = details[1].get("before") if len(details) > 1 else last
    codes = [details[0].get("code", first), *(detail["code"] for detail in details[1:])]
    return [{"from_ms": row["at_ms"], "code": code} for row, code in zip(noted[begins:], codes, strict=True)]


def is_new(store: Store) -> bool:
    """Whether no study was ever run with this database."""
    with store.database.read() as connection:
        return connection.execute(select(study)).first() is None


def has_begun(store: Store) -> bool:
    """Whether somebody has consented, who may be purged: what the study is run with may not change any more."""
    with store.database.read() as connection:
        return _begun(connection)


def _check_same(store: Store, connection: Connection, known: Row[Any], row: Mapping[str, Any]) -> None:
    if known.simulated != row["simulated"]:
        kinds = ("simulated participants", "people") if known.simulated else ("people", "simulated participants")
        look = " (to look at it, for instance on /annotate: serve --rehearse 1)" if known.simulated else ""
        raise StudyError(
            f"this data folder holds what {kinds[0]} did, and {kinds[1]} must not be mixed with them; "
            f"choose another --data folder{look}"
        )
    for what in _changes(known, row):
        how = " (`movingout study backup` writes it as it was, study.yaml, to be served)" if what == _FILE else ""
        raise StudyError(
            f"study {known.id} has begun, and {what} has changed since; "
            f"restore it{how}, or begin a new study with another --data folder, which knows nobody who has taken part: "
            "exclude them where you recruit; signed links stay good if the id stays and studies/ID/link-key is "
            "copied before the first start"
        )
    if known.code != row["code"]:
        connection.execute(update(study).values(code=row["code"]))
        before, code = json.loads(known.code), json.loads(row["code"])
        record(connection, store.now(), "server", "code", before=before, code=code)


def _changes(known: Row[Any], row: Mapping[str, Any]) -> Iterator[str]:
    if known.id != row["id"]:
        yield "its id"
    if known.file_sha256 != row["file_sha256"]:
        yield _FILE
    before, now = json.loads(known.models), json.loads(row["models"])
    for name in sorted(before.keys() & now.keys()):  # earlier versions kept no hashes of maps, …
        if before[name] not in ("", now[name]):  # … nor of files and of agents with options
            yield f"the map {name.removeprefix(MAP)}" if name.startswith(MAP) else f"the agent {name}"


def _begun(connection: Connection) -> bool:
    """Purged units hold their slots, so that what is left of a study is no place for another one."""
    purged = select(units.c.id).where(units.c.state == "purged")
    return _anybody(connection) or connection.execute(purged).first() is not None


def _anybody(connection: Connection) -> bool:
    """Whether somebody has consented, or has finished without, as in data of earlier versions."""
    everybody = set(connection.execute(select(participants.c.pid)).scalars())
    return bool(everybody - undecided_in(connection))
