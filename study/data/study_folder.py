"""Where the data of a study lie: two databases of its own, and the recordings of all."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from filelock import FileLock, Timeout

from movingout.study.design.definition import Study
from movingout.study.design.study_file import parse_study
from movingout.study.errors import StudyError
from movingout.study.store.clock import now_ms
from movingout.study.store.identity import IdentityStore
from movingout.study.store.store import Store


@dataclass(frozen=True, slots=True)
class StudyFolder:
    """The data folder of a study; `database` and `identities` are addresses of PostgreSQL where there is one."""

    study: Study
    data: Path
    database: str | None = None
    identities: str | None = None

    @property
    def own(self) -> Path:
        return self.data / "studies" / self.study.id

    @property
    def recordings(self) -> Path:
        return self.data / "recordings"

    @property
    def rooms(self) -> Path:
        """What the server keeps of its rooms between two starts."""
        return self.data / "rooms"

    def output(self, what: str, simulated: bool) -> Path:
        """Where a report or an export goes by itself; of a rehearsal under a name that says so."""
        return Path(f"{self.study.id}-simulated-{what}" if simulated else f"{self.study.id}-{what}")

    def open(self, now: Callable[[], int] = now_ms) -> Store:
        """The store; it is made when it is new."""
        return Store(self.database or self.own / "study.sqlite", now)

    def open_identities(self, now: Callable[[], int] = now_ms) -> IdentityStore:
        return IdentityStore(self.identities or self.own / "identity.sqlite", now)

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        """Nobody else serves this study meanwhile, or removes anything of it.

        Two servers would hand out the same places, and a server remembers whom somebody removes behind its back.
        Raises StudyError.
        """
        lock = FileLock(self.own / "serving.lock", blocking=False, thread_local=False)
        try:
            self.own.mkdir(parents=True, exist_ok=True)
            lock.acquire()
        except Timeout:
            problem = f"study {self.study.id} is being served from {self.data}; stop that server first"
            raise StudyError(problem) from None
        except OSError as error:
            raise StudyError(f"cannot write to {self.own}: {error.strerror or error}") from None
        try:
            yield
        finally:
            lock.release()

    def as_frozen(self, store: Store, beside: Path) -> "StudyFolder":
        """With the study that the data were recorded with, whatever its file says by now.

        Texts that the study has in files of their own are read `beside` it. Raises StudyError.
        """
        return replace(self, study=parse_study(store.frozen().file_text, "the study as it began", beside))

    def open_existing(self, now: Callable[[], int] = now_ms) -> Store:
        """The store of a study that was run; StudyError when it never was."""
        if self.database is None and not (self.own / "study.sqlite").is_file():
            raise StudyError(
                f"study {self.study.id} has no data in {self.data}; run it first, or name another folder with --data"
            )
        return self.open(now)
