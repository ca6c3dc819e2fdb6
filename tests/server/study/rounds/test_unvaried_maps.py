"""Rounds whose map cannot be varied: whoever meets one gets on, and the experimenter hears of it."""

from pathlib import Path
from typing import Any

import pytest

from movingout.maps import MapError
from movingout.server.rooms.services import RoomConfig
from movingout.study.store.tables import audit, rounds
from tests.server.study.support import PAIR, SOLO, Served, served
from tests.server.study.test_pairs import paired

VARIED = SOLO.replace("limit_ticks: 20, after_partner", "limit_ticks: 20, challenge: 2, after_partner")
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
