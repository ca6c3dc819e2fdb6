"""Every code that the server sends has a text in every language."""

import json
from pathlib import Path
from typing import Any, Literal, get_args

import msgspec
import pytest

from movingout.maps.check import FaultCode, HintCode
from movingout.maps.errors import DocumentFault
from movingout.server import messages as m
from movingout.server.api.errors import ApiError
from movingout.server.notices import NOTHING, AlertCode, ErrorCode, Notice, ReasonCode, RefusalCode, UnrecordedCode
from movingout.server.rooms.room_notices import resumed
from movingout.study.design.definition import Outcome
from tests.server.support import Table
from tests.support import ROOT

CATALOGUES = sorted((ROOT / "web" / "words").glob("*.json"))
CODES = {
    "error": ErrorCode,
    "reason": ReasonCode,
    "refusal": RefusalCode,
    "unrecorded": UnrecordedCode,
    "alert": AlertCode,
    "fault": Literal[FaultCode, DocumentFault, HintCode],
}
OF_PAGES = {  # what a page finds by itself
    "error": {"title", "offline", "http", "storage"},
    "fault": {"no_goals", "no_items"},
}


@pytest.mark.parametrize("catalogue", CATALOGUES, ids=lambda path: path.stem)
def test_every_code_has_a_text_and_every_text_a_code(catalogue: Path) -> None:
    texts: dict[str, str] = json.loads(catalogue.read_text(encoding="utf-8"))
    for kind, codes in CODES.items():
        told = {key.split(".")[1] for key in texts if key.startswith(f"{kind}.")}
        assert told - OF_PAGES.get(kind, set()) == set(get_args(codes)) - {"unreadable"}, kind


def test_every_code_is_said_somewhere() -> None:
    """A code that nothing says has a text in every language that nobody ever reads."""
    sources = [path for folder in ("server", "study") for path in (ROOT / folder).rglob("*.py")]
    said = "".join(path.read_text(encoding="utf-8") for path in sources if path != ROOT / "server" / "notices.py")
    codes = {
        code for kind in (ErrorCode, ReasonCode, RefusalCode, UnrecordedCode, AlertCode) for code in get_args(kind)
    }
    assert {code for code in codes if f'"{code}"' not in said} == set()


@pytest.mark.parametrize("catalogue", CATALOGUES, ids=lambda path: path.stem)
def test_how_a_study_ends_is_told_to_participants_and_experimenters(catalogue: Path) -> None:
    texts: dict[str, str] = json.loads(catalogue.read_text(encoding="utf-8"))
    for outcome in get_args(Outcome):
        lead = f"study.code.{outcome}Lead"
        assert {f"study.code.{outcome}", f"experimenter.outcome.{outcome}"} <= texts.keys(), outcome
        assert lead in texts or {f"{lead}.paid", f"{lead}.unpaid"} <= texts.keys(), outcome
    away = [text for key, text in texts.items() if key.startswith("study.code.dropped-outLead")]
    assert away and "artner" not in str(away), "they may have played with agents"


def test_a_refusal_over_http_carries_its_values() -> None:
    error = ApiError(422, "unknown_map", "unknown map 'X'; known: Y", map="X")
    assert error.as_json() == {
        "error": {"code": "unknown_map", "message": "unknown map 'X'; known: Y", "values": {"map": "X"}}
    }


def test_the_state_of_a_room_names_the_players_for_pages_in_other_languages() -> None:
    table = Table()
    _, red = table.play()
    table.room.depart(red, table.now)
    state = table.room.state()
    assert (state.reason, state.reason_code) == ("Red lost the connection. The game waits.", "waiting")
    assert state.reason_values == {"players": ["red"]}


def test_messages_of_an_earlier_server_without_codes_are_still_read() -> None:
    def decoded(**fields: Any) -> Any:
        return msgspec.json.decode(msgspec.json.encode(fields), type=m.ServerMessage)

    assert decoded(type="bye", code=4005, message="Over.") == m.Bye(4005, "Over.")
    assert decoded(type="error", code="study", message="No.") == m.Problem("study", "No.")


def test_nothing_to_say_is_false() -> None:
    assert not NOTHING and Notice("paused", "Red paused the game.")


def test_a_round_that_goes_on_after_a_restart_says_from_when() -> None:
    """A full disk may have ended its recording before the kill: then people see the game jump back, and why."""
    told = resumed(217)
    assert told.values == {"seconds": 22} and told.message.endswith("at second 22.")
