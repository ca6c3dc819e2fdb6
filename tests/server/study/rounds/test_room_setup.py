"""The rules of a study's rooms follow from its blocks."""

import asyncio
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from movingout.maps import MapError, load_map, map_to_json
from movingout.server.own_maps.solving import TooSlow
from movingout.server.own_maps.workers import Busy
from movingout.server.rooms.services import RoomConfig
from movingout.server.study.rounds.room_setup import RoomSetup
from movingout.study.design.allocation import assign
from movingout.study.design.steps import Step, steps
from movingout.study.design.study_file import parse_study
from tests.server.study.support import SOLO

SECOND = "  - {id: talk, pings: on, partners: [good, bad], maps: [HandOff], limit_ticks: 20}\ndebrief:"


@pytest.mark.parametrize(
    ("text", "rooms"),
    [
        (SOLO, {"practice": False, "play": False}),
        (SOLO.replace("debrief:", SECOND), {"practice": True, "play": False, "talk": True}),
    ],
)
def test_pings_are_on_in_the_blocks_that_say_so_and_in_the_practice_for_them(text: str, rooms: dict[str, bool]) -> None:
    study = parse_study(text)
    host: Any = SimpleNamespace(settings=SimpleNamespace(countdown_s=3.0))
    setup = RoomSetup(study, host, simulated=False)
    played = [step for step in steps(study, assign(study, 0)) if step.kind in ("practice", "round")]
    assert {step.block or "practice": setup.config(step).pings for step in played} == rooms


def test_a_room_has_the_maps_of_ones_own_with_it(tmp_path: Path) -> None:
    den = load_map("FourCorners:mirror")
    (tmp_path / "den.json").write_text(json.dumps(map_to_json(den)), encoding="utf-8")
    study = parse_study(SOLO.replace("maps: [HandOff", "maps: [den.json, HandOff"), folder=tmp_path)
    host: Any = SimpleNamespace(settings=SimpleNamespace(countdown_s=3.0))
    setup = RoomSetup(study, host, simulated=False)
    (tmp_path / "den.json").unlink()
    played = [setup.config(step) for step in steps(study, assign(study, 0)) if step.kind in ("practice", "round")]
    assert {config.maps[0]: config.designed(0) for config in played}["den.json"] == den
    assert all(set(config.own_maps) == {"den.json"} & set(config.maps) for config in played)
    assert setup.shown_map("den.json") == (den.name, den.title)
    assert setup.shown_map("HandOff") == ("HandOff", "Hand Off")
    assert setup.shown_map("gone.json") == ("gone.json", ""), "of a study file that was changed since"


def failing(error: MapError, asked: list[RoomConfig]) -> RoomSetup:
    """The setup of rooms on a server that cannot vary a map; `asked` gets what was asked for."""

    async def prepare_maps(config: RoomConfig) -> None:
        asked.append(config)
        await asyncio.sleep(0)
        raise error

    study = parse_study(SOLO.replace("limit_ticks: 20, after", "challenge: 2, limit_ticks: 20, after"))
    host: Any = SimpleNamespace(settings=SimpleNamespace(countdown_s=3.0), prepare_maps=prepare_maps)
    return RoomSetup(study, host, simulated=False)


def varied_round() -> Step:
    study = parse_study(SOLO.replace("limit_ticks: 20, after", "challenge: 2, limit_ticks: 20, after"))
    return next(step for step in steps(study, assign(study, 0)) if step.kind == "round")


def test_those_who_ask_for_a_map_at_the_same_time_wait_for_one_try() -> None:
    asked: list[RoomConfig] = []
    setup = failing(MapError("too tight"), asked)

    async def ask() -> list[str]:
        given_up = asyncio.create_task(setup.prepare(varied_round()))
        await asyncio.sleep(0)
        given_up.cancel()
        return await asyncio.gather(*(setup.prepare(varied_round()) for _ in range(4)))

    assert (asyncio.run(ask()), len(asked)) == (["too tight"] * 4, 1)
    assert (asyncio.run(setup.prepare(varied_round())), len(asked)) == ("too tight", 1)
    assert setup.map_of(varied_round()) == load_map("HandOff"), "of a round that is played after a restart"


def test_a_map_that_took_too_long_is_tried_once_more() -> None:
    asked: list[RoomConfig] = []
    setup = failing(TooSlow("this took too long"), asked)
    with pytest.raises(Busy, match="took too long"):
        asyncio.run(setup.prepare(varied_round()))
    assert [asyncio.run(setup.prepare(varied_round())) for _ in range(2)] == ["this took too long"] * 2
    assert len(asked) == 2
