"""Rounds that are over and wait to be saved."""

import asyncio
import gc
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any, cast

from movingout.server.public_host import PublicHost
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.rounds.finished_rounds import FinishedRounds
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.study.store.store import Unit

NO_DATABASES = cast(StudyDatabases, None)


@asynccontextmanager
async def of_another_node() -> AsyncIterator[Transaction]:
    yield Transaction(NO_DATABASES, 0.0, in_charge=lambda: False)


async def on_saved(*_: object) -> None:
    """Nothing."""


def test_a_round_that_ends_when_the_study_has_just_moved_is_no_error_of_this_node() -> None:
    async def problems() -> list[Any]:
        heard: list[Any] = []
        asyncio.get_running_loop().set_exception_handler(lambda _, context: heard.append(context["message"]))
        finished = FinishedRounds(cast(PublicHost, None), NO_DATABASES, of_another_node, on_saved)
        finished.save_soon(StudyUnit(Unit(7, 0, ("P1",), False), [], 1))
        for _ in range(5):
            await asyncio.sleep(0.0)
        gc.collect()
        return heard

    assert asyncio.run(problems()) == []
