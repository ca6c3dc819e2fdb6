"""Where the data of a study are stored: its two databases, and the recordings that all studies share."""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

from filelock import FileLock, Timeout

from movingout.maps.files.ownership import make_file, make_folder
from movingout.study.design.definition import Study
from movingout.study.design.study_file import complete_text, parse_study, plain_text
from movingout.study.errors import StudyError
from movingout.study.store import tables
from movingout.study.store.clock import now_ms
from movingout.study.store.database import alone, is_made, shown
from movingout.study.store.frozen_study import frozen_study, has_begun, is_new
from movingout.study.store.identity import IdentityStore
from movingout.study.store.store import Store


@dataclass(frozen=True, slots=True)
class StudyFolder:
    """The data folder of a study; `database` and `identities` are addresses of PostgreSQL databases, if used.

    `fence` is that of a node which runs the study (study.store.database).
    """

    study: Study
    data: Path
    database: str | None = None
    identities: str | None = None
    fence: int = 0

    @property
    def own(self) -> Path:
        return self.data / "studies" / self.study.id

    @property
    def recordings(self) -> Path:
        return self.data / "recordings"

    @property
    def rooms(self) -> Path:
        """Where the server saves its rooms for a restart."""
        return self.data / "rooms"

    def output(self, what: str, simulated: bool) -> Path:
        """The default folder of a report or an export; the name of a rehearsal's says so."""
        return Path(f"{self.study.id}-simulated-{what}" if simulated else f"{self.study.id}-{what}")

    def open(self, now: Callable[[], int] = now_ms) -> Store:
        """The store; created if there is none."""
        return Store(self.database or self.own / "study.sqlite", now, self.fence)

    def open_identities(self, now: Callable[[], int] = now_ms) -> IdentityStore:
        return IdentityStore(self.identities or self.own / "identity.sqlite", now, self.fence)

    @property
    def identity_file(self) -> Path | None:
        """Where identities are kept; None in PostgreSQL."""
        return None if self.identities else self.own / "identity.sqlite"

    @property
    def has_identities(self) -> bool:
        """Whether their file is there, also with no rows any more; in PostgreSQL they always are."""
        file = self.identity_file
        return file is None or (file.is_file() and file.stat().st_size > 0)

    @contextmanager
    def existing_identities(self) -> Iterator[IdentityStore | None]:
        """None where they were deleted or lost: made anew, they would pass for those of a study that needs none."""
        if not self.has_identities:
            yield None
            return
        with closing(self.open_identities()) as identities:
            yield identities

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        """Hold the study for this process: nobody else serves it or deletes from it.

        Two servers would assign the same slots, and a server would still remember participants deleted behind its back.
        Raises StudyError when another process holds it.
        """
        lock = FileLock(self.own / "serving.lock", blocking=False, thread_local=False)
        try:
            make_folder(self.own)
            make_file(Path(lock.lock_file))
            lock.acquire()
        except Timeout:
            problem = f"study {self.study.id} is being served from {self.data}; stop that server first"
            raise StudyError(problem) from None
        except OSError as error:
            raise StudyError(f"cannot write to {self.own}: {error.strerror or error}") from None
        try:
            with alone(self.database) if self.database else nullcontext():
                yield
        finally:
            lock.release()

    def as_frozen(self, store: Store, beside: Path | None) -> "StudyFolder":
        """The folder with the study as it was when the data were recorded, whatever its file says now.

        Texts that the study keeps in files are read from the folder `beside`. Raises StudyError.
        """
        frozen = frozen_study(store)
        study = parse_study(plain_text(frozen.file_text), "the study as it began", beside, begun=True)
        return replace(self, study=study.allocated_by(frozen.allocation))

    def open_existing(self, now: Callable[[], int] = now_ms) -> Store:
        """The store of a study that was run. Raises StudyError when it never was, and for another study's database."""
        self.check_was_run()
        store = self.open(now)
        try:
            self._check_is_own(store)
        except BaseException:
            store.close()
            raise
        return store

    def _check_is_own(self, store: Store) -> None:
        """A file lies in a folder of the study's name; an address may be anybody's. Raises StudyError."""
        if self.database is not None and not is_new(store) and (found := frozen_study(store).id) != self.study.id:
            raise StudyError(
                f"{shown(self.database)} has the data of the study {found}, not of {self.study.id}; give the address "
                f"of the database of {self.study.id}, or the file of {found}"
            )

    def has_begun_with(self, file: Path) -> bool:
        """Whether somebody has consented here to the study that the file describes, as it is now. Raises StudyError."""
        with closing(self.open_existing()) as store:
            begun_with = plain_text(frozen_study(store).file_text) if has_begun(store) else None
        # studies of earlier versions began without the texts that the study keeps in files
        return begun_with in (plain_text(file.read_text(encoding="utf-8")), plain_text(complete_text(file)))

    def check_was_run(self) -> None:
        """Raises StudyError where the study never had a database. Makes none, also where an address is given."""
        if not self.has_database():
            other = "; where it was served from PostgreSQL, say so here too: --cluster or --database"
            where = f"{self.data}; run it first, or name another folder with --data{other}"
            if self.database is not None:
                where = f"{shown(self.database)}, which no study was served from; give the address that served it"
            raise StudyError(f"study {self.study.id} has no data in {where}")
        if self.identities is not None and not is_made(self.identities, tables.identities.name):
            raise StudyError(
                f"study {self.study.id} has no identities in {shown(self.identities)}; give the address that served it"
            )

    def has_database(self) -> bool:
        """Whether there is a database, also one without rows. Raises StudyError for an address that does not answer."""
        if self.database is not None:
            return is_made(self.database, tables.study.name)
        return (self.own / "study.sqlite").is_file()
