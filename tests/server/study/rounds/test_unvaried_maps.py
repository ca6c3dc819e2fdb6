"""Rounds whose map cannot be varied: whoever meets one gets on, and the experimenter hears of it."""

import asyncio
from pathlib import Path
from typing import Any

import pytest

from movingout.maps import MapError
from movingout.server.rooms.services import RoomConfig
from movingout.study.store.tables import audit, rounds
from tests.server.live import WAIT_S
from tests.server.study.support import PAIR, SOLO, Served, Visitor, served
from tests.server.study.test_pairs import paired

VARIED = SOLO.replace("limit_ticks: 20, after_partner", "limit_ticks: 20, challenge: 2, after_partner")
OF_A_PAIR = PAIR.replace("rounds: 2", "map_order: fixed, maps: [PriorityPick, HandOff], challenge: 2")
OF_A_PAIR = OF_A_PAIR.replace("maps: [HandOff], ", "")
TWO_MAPS = VARIED.replace("[HandOff]", "[HandOff, PriorityPick]").replace("[good, bad]", "[good]")


def without_variants(study: Served, monkeypatch: pytest.MonkeyPatch, tight: str) -> list[RoomConfig]:
    """A map that cannot be varied; returns all that were asked for."""
    asked: list[RoomConfig] = []
    make = study.running.host.prepare_maps

    async def prepare(config: RoomConfig, address: str = "") -> None:
        asked.append(config)
        if config.maps == (tight,):
            raise MapError(f"no playable train variant of {tight}")
        await make(config, address)

    monkeypatch.setattr(study.running.host, "prepare_maps", prepare)
    return asked


def kept(study: Served) -> list[tuple[Any, ...]]:
    columns = "outcome", "ticks", "valid", "attempt"
    return [tuple(row[name] for name in columns) for row in study.running.databases.store.rows(rounds)]


def test_a_round_without_a_variant_is_skipped_as_invalid_with_its_questions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served(tmp_path, TWO_MAPS) as study:
        without_variants(study, monkeypatch, "HandOff")
        study.visitor().go_to("questionnaire")
        (alert,) = [one for one in study.state()["alerts"] if one["about"] == "unvaried"]
        assert alert["values"] == {"unit": 1, "map": "HandOff"}
        assert alert["detail"] == "no playable train variant of HandOff"
        assert sorted(kept(study)) == [("error", 0, False, 1), ("time", 20, True, 1)]
        assert "skip-round" in [row["action"] for row in study.running.databases.store.rows(audit)]


def test_who_meets_no_partner_at_all_reaches_the_code_and_is_paid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served(tmp_path, VARIED) as study:
        asked = without_variants(study, monkeypatch, "HandOff")
        visitor = study.visitor().go_to("debrief")
        assert len(asked) == 1, "what cannot be made is not tried again"
        visitor.go_to("code")
        assert visitor.step["outcome"] == "done" and visitor.step["earned"] is not None
        assert len(kept(study)) == 2


def test_both_of_a_pair_skip_the_round_which_is_kept_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with served(
        tmp_path,
        PAIR.replace("rounds: 2", "maps: [HandOff, PriorityPick], challenge: 2").replace("maps: [HandOff], ", ""),
    ) as study:
        without_variants(study, monkeypatch, "HandOff")
        first, second = paired(study)
        for one in (first, second):
            one.next(done=True)
            assert (one.kind, one.step["map"]["name"]) == ("round", "PriorityPick")
        assert kept(study) == [("error", 0, False, 1)]


def moved(study: Served, visitor: Visitor, step: int | None = None) -> None:
    """The server moves them, be it to the first or second round, and their page does not ask for it yet."""

    async def move() -> None:
        session = study.running.participants[visitor.pid]
        async with study.running.transaction() as tx:
            if step is None:
                await study.running.progress.advance(tx, session)
            else:
                rounds_of = [one.key for one in session.steps if one.kind == "round"]
                await study.running.participants.move(tx, session, rounds_of[step])

    asyncio.run_coroutine_threadsafe(move(), study.live.loop).result(WAIT_S)


def test_a_pair_skips_its_last_round_together_whoever_looks_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served(tmp_path, OF_A_PAIR) as study:
        without_variants(study, monkeypatch, "HandOff")
        first, second = paired(study)
        for one in (first, second):
            moved(study, one, 1)
        first.look()
        study.look()
        second.look()
        assert (first.step["outcome"], second.step["outcome"]) == ("done", "done")


@pytest.mark.parametrize("restart", [False, True])
def test_who_comes_later_passes_the_round_that_the_partner_skipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, restart: bool
) -> None:
    with served(tmp_path, OF_A_PAIR) as study:
        without_variants(study, monkeypatch, "HandOff")
        first, second = paired(study)
        moved(study, second, 0)
        moved(study, first, 1)
        assert first.look()["step"]["outcome"] == "done"
        if not restart:
            moved(study, second)
            assert second.look()["step"]["outcome"] == "done"
    if restart:
        with served(tmp_path, OF_A_PAIR) as study:  # the map could be varied now
            second = Visitor(study, second.token, second.view)
            moved(study, second)
            assert second.look()["step"]["outcome"] == "done"


def test_a_round_that_is_played_after_a_restart_is_not_skipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with served(tmp_path, VARIED) as study:
        visitor = study.visitor().go_to("round")
        visitor.next()
        visitor.wait_until(lambda one: one.step.get("state") == "playing")
        without_variants(study, monkeypatch, "HandOff")
        study.live.run(study.running.host.prepared_maps._made.clear)
        assert visitor.look()["step"]["state"] == "playing"
