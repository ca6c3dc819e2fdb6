"""When a study has everybody it needs: whole units count, not people."""

import asyncio
from pathlib import Path

from movingout.server.host import Host
from movingout.server.settings import Settings
from movingout.server.study.arrivals.arrival_link import LINK, Arrival, ArrivalRefused
from movingout.server.study.arrivals.session_service import SessionService
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.transaction import Transaction
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Outcome
from movingout.study.design.study_file import parse_study
from tests.server.study.support import PAIR

TWO_PAIRS = PAIR.replace("participants: 400", "participants: 4")


async def ended(study: RunningStudy, tx: Transaction, *outcomes: Outcome) -> None:
    """A unit of so many people comes and goes."""
    number = len(list(study.participants))
    members = [await study.participants.arrive(tx, f"P{number + one}", "en", LINK) for one in range(len(outcomes))]
    await study.units.form(tx, members)
    for session, outcome in zip(members, outcomes, strict=True):
        await study.participants.finish(tx, session, outcome)


async def is_full(study: RunningStudy) -> bool:
    try:
        await SessionService(study).arrive(Arrival(LINK, f"new-{len(list(study.participants))}", {}), "en")
    except ArrivalRefused as error:
        return error.code == "study_full"
    return False


def test_pairs_that_lack_one_leave_their_place_to_others_and_an_agents_partner_takes_one(tmp_path: Path) -> None:
    async def test() -> None:
        study = RunningStudy(StudyFolder(parse_study(TWO_PAIRS), tmp_path), TWO_PAIRS, Host(Settings(data=tmp_path)))
        try:
            async with study.transaction() as tx:
                await ended(study, tx, "done", "withdrew")
                await ended(study, tx, "dropped-out", "done")
                await ended(study, tx, "done", "done")
            assert (study.participants.complete_units, await is_full(study)) == (1, False)
            async with study.transaction() as tx:
                await ended(study, tx, "done")
            assert (study.participants.complete_units, await is_full(study)) == (2, True)
        finally:
            study.databases.close()
        again = RunningStudy(StudyFolder(parse_study(TWO_PAIRS), tmp_path), TWO_PAIRS, Host(Settings(data=tmp_path)))
        try:
            async with again.transaction() as tx:
                await again.participants.restore(tx, {})
            assert await is_full(again), "after a restart, too"
        finally:
            again.databases.close()

    asyncio.run(test())
