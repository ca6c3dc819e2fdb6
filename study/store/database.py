"""Databases: a file of SQLite, or PostgreSQL by URL; brought to the newest schema when they are opened."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

from alembic import command
from alembic.config import Config
from sqlalchemy import Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, SQLAlchemyError

from movingout.maps.extras import needs_extra
from movingout.study.errors import StoreError, StoreLocked

Kind = Literal["main", "identity"]
BUSY_S = 1.0  # how long a query waits for another program; all others wait behind it
_MIGRATIONS = Path(__file__).parent / "migrations"


class Database:
    """One database. Every method that touches it raises StoreError in a sentence."""

    def __init__(self, address: Path | str, kind: Kind) -> None:
        self.address = address
        self._engine = _file_engine(address) if isinstance(address, Path) else _url_engine(address)
        self._writer = self._engine.execution_options(begin="BEGIN IMMEDIATE")  # SQLite: no upgrade can fail later
        try:
            with self.write() as connection:
                command.upgrade(alembic_config(kind, connection), "head")
        except BaseException:
            self.close()
            raise

    @contextlib.contextmanager
    def read(self) -> Iterator[Connection]:
        """A consistent view."""
        with _sentences(self.address), self._engine.begin() as connection:
            yield connection

    @contextlib.contextmanager
    def write(self) -> Iterator[Connection]:
        """One transaction: all of it is on the disk when the block ends, or none."""
        with _sentences(self.address), self._writer.begin() as connection:
            yield connection

    def scrub(self) -> None:
        """Overwrite what was deleted, also in the write-ahead log."""
        with _sentences(self.address):
            if self._engine.dialect.name == "sqlite":
                with self._engine.execution_options(begin="").connect() as connection:
                    connection.exec_driver_sql("VACUUM")
                    connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
            else:
                with self._engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
                    connection.exec_driver_sql("VACUUM FULL")

    def close(self) -> None:
        self._engine.dispose()


@contextlib.contextmanager
def _sentences(address: Path | str) -> Iterator[None]:
    try:
        yield
    except DBAPIError as error:
        reason = _reason(error)
        kind = StoreLocked if "locked" in reason else StoreError
        raise kind(f"the database {shown(address)} refused this: {reason}") from error
    except SQLAlchemyError as error:
        raise StoreError(f"the database {shown(address)} cannot be used: {error}") from error


def shown(address: Path | str) -> str:
    """The address without its password."""
    return str(address) if isinstance(address, Path) else make_url(address).render_as_string(hide_password=True)


def _reason(error: DBAPIError) -> str:
    """The database's own first line, with what would help where that is known."""
    text = str(error.orig).strip().splitlines()[0]
    hints = {
        "readonly": "make the file and its folder writable",
        "full": "free some space; nothing that was confirmed is lost",
        "locked": "another program holds it; close it",
        "unable to open": "the folder must exist and be writable",
        "not a database": "it is no SQLite file; move it away",
    }
    return next((f"{text}; {hint}" for word, hint in hints.items() if word in text), text)


def _file_engine(path: Path) -> Engine:
    """SQLite in WAL mode: readers never wait, a commit is on the disk, deleted rows are overwritten."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        os.close(os.open(path, os.O_CREAT, 0o600))
    except OSError as error:
        raise StoreError(f"cannot open the database {path}: {error.strerror or error}") from None
    engine = create_engine(f"sqlite:///{path}", connect_args={"timeout": BUSY_S})

    @event.listens_for(engine, "connect")
    def prepare(connection: Any, record: Any) -> None:
        connection.isolation_level = None  # transactions are begun below, not by the driver
        cursor = connection.cursor()
        for pragma in ("journal_mode=WAL", "synchronous=FULL", "foreign_keys=ON", "secure_delete=ON"):
            cursor.execute(f"PRAGMA {pragma}")
        cursor.close()

    @event.listens_for(engine, "begin")
    def begin(connection: Connection) -> None:
        statement = connection.get_execution_options().get("begin", "BEGIN")
        if statement:
            connection.exec_driver_sql(statement)

    return engine


def _url_engine(url: str) -> Engine:
    try:
        parsed = make_url(url)
    except ArgumentError:
        raise StoreError(
            f"{url!r} is not the address of a database; it should look like postgresql://user@host/name"
        ) from None
    if parsed.get_backend_name() != "postgresql":
        raise StoreError(
            f"{parsed.get_backend_name()} is not supported; give a postgresql:// address, or none for SQLite"
        )
    with needs_extra("postgres", "PostgreSQL"):
        return create_engine(parsed.set(drivername="postgresql+psycopg"), pool_pre_ping=True)


def alembic_config(kind: Kind, connection: Connection) -> Config:
    """The migrations of a kind of database, to run on this connection."""
    config = Config()
    config.set_main_option("script_location", str(_MIGRATIONS))
    config.set_main_option("version_locations", str(_MIGRATIONS / kind))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    return config
