"""The right to change who is where in a study: handed out by `RunningStudy.transaction()`, to one holder at a time."""

import time
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from movingout.server.study.databases import StudyDatabases
from movingout.study.errors import StoreFenced

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class Transaction:
    """Valid inside one `async with study.transaction()` block. Every method that takes one relies on being alone.

    It puts changes in order and undoes nothing: each call of `run` is committed on its own.
    """

    def __init__(self, databases: StudyDatabases, asked: float, in_charge: Callable[[], bool]) -> None:
        self._databases = databases
        self._in_charge = in_charge
        self._asked = asked  # since when it waited to begin, in seconds of the monotonic clock
        self._began = False
        self._open = True

    def check(self) -> None:
        """Raises RuntimeError once the block has ended, StoreFenced where another server runs the study now."""
        if not self._open:
            raise RuntimeError("this transaction has ended; begin another: async with study.transaction()")
        if not self._in_charge():
            raise StoreFenced("another node runs the study now")

    async def run(self, work: Callable[Arguments, Result], *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        """Do `work` in the thread of the databases. Raises StoreError."""
        self.check()
        asked = time.monotonic() if self._began else self._asked
        self._began = True
        return await self._databases.run_asked(asked, work, *args, **kwargs)

    def end(self) -> None:
        self._open = False
