"""`movingout agents` as somebody at a terminal sees it."""

import json

import pytest

from agents.catalogue import agent_cards
from server.cli import main


def test_the_list_has_every_agent(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["agents", "list"]) == 0
    printed = capsys.readouterr().out
    assert all(card.id in printed for card in agent_cards())
    assert main(["agents", "list", "--json"]) == 0
    assert [card["id"] for card in json.loads(capsys.readouterr().out)["agents"]] == [card.id for card in agent_cards()]


def test_one_agent_is_shown_and_an_unknown_one_is_answered_with_those_there_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["agents", "show", "idle"]) == 0
    assert "Stands still" in capsys.readouterr().out
    assert main(["agents", "show", "scriptet"]) == 2
    assert "known: scripted" in capsys.readouterr().err


def test_a_probe_times_the_decisions(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["agents", "probe", "idle", "--ticks", "5", "--json"]) == 0
    probe = json.loads(capsys.readouterr().out)
    assert (probe["id"], probe["ticks"], probe["threads"], probe["holds_10hz"]) == ("idle", 5, 1, True)
    assert 1 <= probe["decision_ms"]["n"] <= 5
    assert 0 <= probe["decision_ms"]["p50"] <= probe["decision_ms"]["p99"]
