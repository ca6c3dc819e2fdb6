"""A unit stands still while dialogs about it are open on experimenters' pages; it goes on when the last one closes."""

import json
from pathlib import Path

import pytest

from movingout.server.study.experimenter_actions import ExperimenterActions, ExperimenterRequest
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.unit import StudyUnit
from movingout.study.errors import StudyError
from movingout.study.store.tables import audit
from tests.server.study.test_transaction import at_practice, run

Presses = tuple[tuple[str, str | None], ...]


def actions(study: RunningStudy) -> ExperimenterActions:
    return ExperimenterActions(study, None)  # type: ignore[arg-type]  # codes are not asked for


async def press(study: RunningStudy, unit: StudyUnit, action: str, hold: str | None) -> None:
    request = ExperimenterRequest(unit=unit.record.id, hold=hold)
    await (actions(study).pause if action == "pause" else actions(study).resume)(request)


@pytest.mark.parametrize(
    ("presses", "paused"),
    [
        ((("pause", "a"), ("resume", "a")), False),
        ((("pause", "a"), ("pause", "b"), ("resume", "a")), True),
        ((("pause", "a"), ("pause", "b"), ("resume", "a"), ("resume", "b")), False),
        ((("pause", "a"), ("pause", "b"), ("resume", "b"), ("resume", "a")), False),
        ((("pause", None), ("pause", "a"), ("resume", "a")), True),
        ((("pause", "a"), ("pause", None), ("resume", "a")), True),
        ((("pause", "a"), ("pause", "b"), ("resume", None)), False),
        ((("pause", "a"), ("resume", None), ("pause", None), ("resume", "a")), True),
        ((("pause", None), ("resume", "of before a restart")), True),
    ],
)
def test_a_unit_goes_on_when_nobody_holds_it_and_nobody_paused_it(
    tmp_path: Path, presses: Presses, paused: bool
) -> None:
    async def test(study: RunningStudy) -> None:
        _, session, unit = await at_practice(study)
        for action, hold in presses:
            await press(study, unit, action, hold)
        assert study.progress.is_paused(session) == paused

    run(tmp_path, test)


def test_a_restart_of_the_server_ends_holds_and_no_pause(tmp_path: Path) -> None:
    async def test(study: RunningStudy) -> None:
        _, _, unit = await at_practice(study)
        await press(study, unit, "pause", "a")
        assert [one.paused for one in study.databases.store.units_on_their_way()] == [False]
        await press(study, unit, "pause", None)
        await press(study, unit, "resume", "a")
        assert [one.paused for one in study.databases.store.units_on_their_way()] == [True]

    run(tmp_path, test)


def test_the_audit_tells_holds_of_dialogs_from_pauses(tmp_path: Path) -> None:
    async def test(study: RunningStudy) -> None:
        _, _, unit = await at_practice(study)
        presses: Presses = (("pause", None), ("pause", "a"), ("resume", "a"))
        for action, hold in presses:
            await press(study, unit, action, hold)
        rows = [row for row in study.databases.store.rows(audit) if row["action"] in ("pause", "resume")]
        held = {"unit": unit.record.id, "hold": True}
        assert [json.loads(row["detail"]) for row in rows] == [{"unit": unit.record.id}, held, held]

    run(tmp_path, test)


def test_a_hold_is_of_a_unit(tmp_path: Path) -> None:
    async def test(study: RunningStudy) -> None:
        with pytest.raises(StudyError):
            await actions(study).pause(ExperimenterRequest(hold="a"))
        assert not study.progress.paused

    run(tmp_path, test)
