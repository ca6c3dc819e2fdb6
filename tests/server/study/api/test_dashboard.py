"""What the experimenter's page is sent, and what the server keeps for it."""

import asyncio
import json
from dataclasses import replace
from typing import Any

from movingout.server.study.api.dashboard import GONE_FOR, Dashboard
from movingout.server.study.api.participant_view import ParticipantViews
from movingout.server.study.participants import Participants
from tests.server.live import WAIT_S
from tests.server.study.support import Served

GONE_AT_ONCE = 3


def strangers_pass_by(solo: Served, dashboard: Dashboard, versions: int) -> None:
    """So many versions later, each with strangers of its own: those of the one before are gone."""
    running = solo.running
    sample = solo.visitor().go_to("form").pid

    async def pass_by() -> None:
        real, record = running.participants, running.participants[sample].record
        try:
            for _ in range(versions):
                running.participants = Participants(running.study, running.databases)
                for number in range(GONE_AT_ONCE):
                    pid = f"X{dashboard.version}-{number}"
                    running.participants._add(replace(record, pid=pid, unit=None), "link")
                dashboard._made_at = -1.0
                await dashboard.refresh()
        finally:
            running.participants = real

    asyncio.run_coroutine_threadsafe(pass_by(), solo.live.loop).result(WAIT_S)


def news(solo: Served, dashboard: Dashboard, since: int) -> dict[str, Any]:
    async def first() -> str:
        return next(dashboard.news(since))

    return dict(json.loads(asyncio.run_coroutine_threadsafe(first(), solo.live.loop).result(WAIT_S)))


def test_strangers_who_have_gone_are_forgotten_and_a_page_from_before_gets_everything(solo: Served) -> None:
    crowded = Dashboard(solo.running, ParticipantViews(solo.running))
    strangers_pass_by(solo, crowded, 2 * GONE_FOR)
    kept = sum(len(pids) for pids in (crowded._rows, crowded._changed, crowded._gone, crowded._last_rounds))
    assert kept <= GONE_AT_ONCE * (GONE_FOR + 3)
    newest = [f"X{2 * GONE_FOR - 1}-{number}" for number in range(GONE_AT_ONCE)]
    for since, gone in ((GONE_FOR, GONE_FOR * GONE_AT_ONCE), (2 * GONE_FOR - 1, GONE_AT_ONCE), (2 * GONE_FOR, 0)):
        told = news(solo, crowded, since)
        assert told["partial"] and len(told["gone"]) == gone, since
        assert [row["pid"] for row in told["participants"]] == (newest if since < 2 * GONE_FOR else [])
    for since in (-1, GONE_FOR - 1):
        told = news(solo, crowded, since)
        assert not told["partial"] and told["gone"] == []
        assert [row["pid"] for row in told["participants"]] == newest
