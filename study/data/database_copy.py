"""All rows of a database of a study into another one, between SQLite and PostgreSQL in both directions."""

import itertools
from contextlib import ExitStack, closing
from pathlib import Path

from sqlalchemy import Connection, MetaData, Table, func, insert, select, text

from movingout.study.errors import StudyError
from movingout.study.store.database import Database, Kind, shown
from movingout.study.store.tables import identity_metadata, metadata

_BATCH = 1000  # rows at a time, so that memory does not grow with the study
TABLES: dict[Kind, MetaData] = {"main": metadata, "identity": identity_metadata}


def save_database(address: str, kind: Kind, file: Path) -> None:
    """A PostgreSQL database as of one moment, also while it is served, as a new file of SQLite. Raises StoreError."""
    with (
        closing(Database(address, kind)) as source,
        closing(Database(file, kind)) as target,
        source.snapshot() as reading,
        target.write() as writing,
    ):
        _copy(reading, writing, TABLES[kind])


def fill_databases(files: dict[Kind, Path], addresses: dict[Kind, str]) -> None:
    """The saved files into empty PostgreSQL databases: all of them, or none. Raises StudyError.

    Each kind that has an address is filled; where it has no file, its database must be empty all the same.
    """
    with ExitStack() as stack:
        writing: dict[Kind, Connection] = {}
        for kind, address in addresses.items():
            target = stack.enter_context(closing(Database(address, kind)))
            writing[kind] = stack.enter_context(target.write())
            _refuse_used(writing[kind], TABLES[kind], address)
        for kind, file in files.items():
            if kind in writing:
                source = stack.enter_context(closing(Database(file, kind)))
                with source.read() as reading:
                    _copy(reading, writing[kind], TABLES[kind])


def refuse_used(addresses: dict[Kind, str]) -> None:
    """Raises StudyError when one of these databases has rows."""
    for kind, address in addresses.items():
        with closing(Database(address, kind)) as target, target.read() as connection:
            _refuse_used(connection, TABLES[kind], address)


def _refuse_used(connection: Connection, tables: MetaData, address: str) -> None:
    for table in tables.sorted_tables:
        if connection.execute(select(table).limit(1)).first() is not None:
            raise StudyError(f"{shown(address)} has data of a study already; give the address of an empty database")


def _copy(source: Connection, target: Connection, tables: MetaData) -> None:
    """Tables in the order in which they refer to each other."""
    for table in tables.sorted_tables:
        found = source.execute(select(table).execution_options(stream_results=True, yield_per=_BATCH)).mappings()
        while rows := [dict(row) for row in itertools.islice(found, _BATCH)]:
            target.execute(insert(table), rows)
        if target.dialect.name == "postgresql":
            _count_on(target, table)


def _count_on(connection: Connection, table: Table) -> None:
    """Let the next row of a numbered table get the number after the highest."""
    column = table.autoincrement_column
    if column is None:
        return
    highest = connection.execute(select(func.max(column))).scalar()
    if highest is not None:
        named = {"table": table.name, "column": column.name, "highest": highest}
        connection.execute(text("SELECT setval(pg_get_serial_sequence(:table, :column), :highest)"), named)
