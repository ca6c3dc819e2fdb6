"""Databases: a file of SQLite, or PostgreSQL by URL; brought to the newest schema when they are opened.

Of several servers that share a PostgreSQL database, the one with the highest *fence* may write: it raises the number
in the database when it opens it, and every transaction reads that number under a lock before it commits.
"""

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

from alembic import command
from alembic.config import Config
from alembic.util import CommandError
from sqlalchemy import URL, Connection, Engine, create_engine, event, inspect, make_url, text
from sqlalchemy.exc import DBAPIError, SQLAlchemyError
from sqlalchemy.schema import CreateSchema

from movingout.study.errors import StoreError, StoreFenced, StoreLocked
from movingout.study.store.postgres import Connections, gave_up, postgres_engine

Kind = Literal["main", "identity"]
BUSY_S = 1.0  # how long a query waits for another program; all others wait behind it
ANSWER_S = 5  # the same for PostgreSQL, and for any answer of it
FENCED_S = 3  # after which the database gives up a transaction of a server that hangs, so that another can go on
UPGRADE = 7_306_412  # a lock of PostgreSQL, while tables are made: any number that nobody else uses
SERVED = 7_306_413  # another one: fenced servers share it, who deletes or serves alone has it for itself
UNSCRUBBED = "movingout_unscrubbed"  # a table that is there while something deleted has not been overwritten
NUL = "\0"  # the one character that PostgreSQL keeps in no text
_TRIES, _BETWEEN_TRIES_S = 8, 0.25  # for the lock of servers that have just ended
_MIGRATIONS = Path(__file__).parent / "migrations"


class Database:
    """One database. Every method that touches it raises StoreError in a sentence.

    With a `fence` above 0, of PostgreSQL only, this server writes until one with a higher fence opens the database;
    then each write raises StoreFenced.
    """

    def __init__(self, address: Path | str, kind: Kind, fence: int = 0) -> None:
        self.address = address
        self._fence = 0
        self._engine = _file_engine(address) if isinstance(address, Path) else postgres_engine(address)
        self._connections = None if isinstance(address, Path) else Connections(self._engine)
        self._patient = False  # while something takes long and is not to be given up
        if fence:
            event.listen(self._engine, "connect", _give_up_soon)
        self._writer = self._engine.execution_options(begin="BEGIN IMMEDIATE")  # SQLite: no upgrade can fail later
        try:
            with self.write() as connection:
                if connection.dialect.name == "postgresql":
                    connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({UPGRADE})")
                    _make_schema(connection)
                _upgrade(kind, connection, address)
            if fence:
                self._take_over(fence)
        except BaseException:
            self.close()
            raise

    @contextlib.contextmanager
    def read(self) -> Iterator[Connection]:
        """A consistent view."""
        with _sentences(self.address), self._engine.begin() as connection:
            yield connection

    @contextlib.contextmanager
    def snapshot(self) -> Iterator[Connection]:
        """A consistent view over many queries, as of one moment."""
        level = {"isolation_level": "REPEATABLE READ"} if self._engine.dialect.name == "postgresql" else {}
        with _sentences(self.address), self._engine.execution_options(**level).begin() as connection:
            yield connection

    @contextlib.contextmanager
    def write(self) -> Iterator[Connection]:
        """One transaction: all of it is on the disk when the block ends, or none."""
        with _sentences(self.address), self._writer.begin() as connection:
            if self._fence:
                self._check_fence(connection)
            yield connection

    def _take_over(self, fence: int) -> None:
        """Wait for the writes of the last server, and let no further one begin."""
        with self.write() as connection:
            connection.exec_driver_sql("CREATE TABLE IF NOT EXISTS movingout_fence (number bigint PRIMARY KEY)")
            connection.exec_driver_sql("LOCK TABLE movingout_fence IN SHARE ROW EXCLUSIVE MODE")
            connection.exec_driver_sql(
                "INSERT INTO movingout_fence SELECT 0 WHERE NOT EXISTS (SELECT FROM movingout_fence)"
            )
            raised = text("UPDATE movingout_fence SET number = :fence WHERE number <= :fence RETURNING number")
            if connection.execute(raised, {"fence": fence}).first() is None:
                raise StoreFenced(
                    f"{_FENCED}, with a higher fencing token than {fence}. If none does, because the tables of the "
                    "cluster were made anew: DELETE FROM movingout_fence in this database"
                )
        self._fence = fence

    def _check_fence(self, connection: Connection) -> None:
        newest = connection.execute(text("SELECT number FROM movingout_fence FOR SHARE")).scalar_one()
        if newest != self._fence:
            raise StoreFenced(_FENCED)

    def mark_deleted(self, connection: Connection) -> None:
        """Remember, in the transaction that deletes something, that `scrub` is due: a kill may come before it."""
        connection.exec_driver_sql(f"CREATE TABLE IF NOT EXISTS {UNSCRUBBED} (number integer)")

    def is_unscrubbed(self) -> bool:
        """Whether something was deleted, here or before a kill, that has not been overwritten."""
        with self.read() as connection:
            return inspect(connection).has_table(UNSCRUBBED)

    def scrub(self) -> None:
        """Overwrite what was deleted, also in the write-ahead log. Raises StoreFenced while another node serves.

        Raises StoreError while another program reads a file: what it reads stays. No StoreLocked, others can write.
        """
        if self._fence:
            with self.write():
                pass
        with _sentences(self.address):
            if self._engine.dialect.name == "sqlite":
                with self._engine.execution_options(begin="").connect() as connection:
                    connection.exec_driver_sql("VACUUM")
                    if connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)").one()[0]:
                        raise StoreError(f"what was deleted is still in {shown(self.address)}: {_READ}")
            else:
                self._vacuum()
        if self.is_unscrubbed():
            with self.write() as connection:
                connection.exec_driver_sql(f"DROP TABLE IF EXISTS {UNSCRUBBED}")

    def scrub_rest(self) -> None:
        """Overwrite what was deleted before a kill or an error, where there is any."""
        if self.is_unscrubbed():
            self.scrub()

    def _vacuum(self) -> None:
        self._patient = True
        try:
            with self._engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
                usual = connection.exec_driver_sql("SHOW statement_timeout").scalar_one()
                connection.exec_driver_sql("SET statement_timeout = 0")
                try:
                    connection.exec_driver_sql("VACUUM FULL")
                finally:
                    connection.exec_driver_sql(f"SET statement_timeout = '{usual}'")
        finally:
            self._patient = False

    # ---- a database that does not answer --------------------------------------------------------------------------

    def hurry(self) -> None:
        """From now on PostgreSQL itself gives up what takes longer than ANSWER_S: in a server, all wait behind it."""
        if self._connections is not None:
            event.listen(self._engine, "connect", _hurry)
            self._engine.dispose()

    def give_up(self, since: float) -> bool:
        """Cut the connections if PostgreSQL has said nothing for ANSWER_S to who asks since then (monotonic clock)."""
        if self._connections is None or self._patient:
            return False
        if time.monotonic() - max(since, self._connections.heard_at) < ANSWER_S:
            return False
        self._connections.hang_up()
        return True

    def close(self) -> None:
        self._engine.dispose()


@contextlib.contextmanager
def _sentences(address: Path | str) -> Iterator[None]:
    try:
        yield
    except DBAPIError as error:
        reason = _reason(error)
        kind = StoreLocked if "locked" in reason or gave_up(error) else StoreError
        raise kind(f"the database {shown(address)} refused this: {reason}") from error
    except SQLAlchemyError as error:
        raise StoreError(f"the database {shown(address)} cannot be used: {error}") from error


def shown(address: Path | str) -> str:
    """The address without its password."""
    return str(address) if isinstance(address, Path) else make_url(address).render_as_string(hide_password=True)


_DAMAGED = "the file is damaged, or no database; bring back the last backup: movingout study restore"
_READ = "another program reads it; close it, and the next start of the study, or `study purge --apply`, overwrites it"
_FENCED = "another node runs the study now"


def _reason(error: DBAPIError) -> str:
    """The database's own first line, with what would help where that is known."""
    text = str(error.orig).strip().splitlines()[0]
    hints = {
        "readonly": "make the file and its folder writable",
        "full": "free some space; nothing that was confirmed is lost",
        "locked": "another program holds it; close it",
        "unable to open": "the folder must exist and be writable",
        "not a database": _DAMAGED,
        "malformed": _DAMAGED,
        "statement timeout": "another program may hold it",
        "lock timeout": "another program holds it",
        "closed the connection": "it ended, or did not answer in time",
        "timeout expired": "it does not answer",
    }
    return next((f"{text}; {hint}" for word, hint in hints.items() if word in text), text)


def _file_engine(path: Path) -> Engine:
    """SQLite in WAL mode: readers never wait, a commit is on the disk, deleted rows are overwritten."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        os.close(os.open(path, os.O_CREAT, 0o600))
    except OSError as error:
        raise StoreError(f"cannot open the database {path}: {error.strerror or error}") from None
    engine = create_engine(URL.create("sqlite", database=str(path)), connect_args={"timeout": BUSY_S})

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


def _make_schema(connection: Connection) -> None:
    """The schema that the address names first, where it is not there yet."""
    if connection.exec_driver_sql("SELECT current_schema()").scalar_one() is None:
        path = connection.exec_driver_sql("SHOW search_path").scalar_one()
        name = str(path).partition(",")[0].strip().strip('"')
        connection.execute(CreateSchema(name, if_not_exists=True))


def _give_up_soon(connection: Any, record: Any) -> None:
    with connection.cursor() as cursor:
        cursor.execute(f"SET idle_in_transaction_session_timeout = '{FENCED_S}s'")
        cursor.execute(f"SET lock_timeout = '{3 * FENCED_S}s'")
        cursor.execute(f"SELECT pg_advisory_lock_shared({SERVED})")  # as long as this connection lasts
    connection.commit()


def _hurry(connection: Any, record: Any) -> None:
    with connection.cursor() as cursor:
        cursor.execute(f"SET statement_timeout = '{ANSWER_S}s'")
        cursor.execute(f"SET lock_timeout = '{ANSWER_S}s'")  # also of a VACUUM, which may take longer than a statement
    connection.commit()


def is_made(address: str, table: str) -> bool:
    """Whether a PostgreSQL database has a table of this name; makes nothing there. Raises StoreError."""
    engine = postgres_engine(address)
    try:
        with _sentences(address), engine.connect() as connection:
            return inspect(connection).has_table(table)
    finally:
        engine.dispose()


@contextlib.contextmanager
def alone(address: str) -> Iterator[None]:
    """Keep fenced servers out of a PostgreSQL database. Raises StoreError while one serves from it.

    One that has just ended has a moment: PostgreSQL lets go when it has noticed.
    """
    engine = postgres_engine(address)
    try:
        with _sentences(address), engine.connect() as connection:
            for _ in range(_TRIES):
                free = connection.execute(text("SELECT pg_try_advisory_lock(:lock)"), {"lock": SERVED}).scalar_one()
                connection.commit()
                if free:
                    break
                time.sleep(_BETWEEN_TRIES_S)
            else:
                raise StoreError(f"a study is being served from {shown(address)}; stop its servers first")
            yield
    finally:
        engine.dispose()


def _upgrade(kind: Kind, connection: Connection, address: Path | str) -> None:
    """To the newest schema. Raises StoreError for a schema that this version does not know."""
    try:
        command.upgrade(alembic_config(kind, connection), "head")
    except CommandError as error:
        raise StoreError(
            f"the database {shown(address)} was written by a newer version of this program; use that one ({error})"
        ) from None


def alembic_config(kind: Kind, connection: Connection) -> Config:
    """The migrations of a kind of database, to run on this connection."""
    config = Config()
    config.set_main_option("script_location", str(_MIGRATIONS))
    config.set_main_option("version_locations", str(_MIGRATIONS / kind))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    return config
