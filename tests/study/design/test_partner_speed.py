"""Partners that decide too slowly for this machine: what `study check` says."""

import json
from pathlib import Path

import pytest

from movingout.agents.trial import NotReadyError
from movingout.server.cli import main
from movingout.study.design import partner_speed
from movingout.study.design.study_file import read_study
from tests.study.design.small_study import SMALL

SLOW = (
    "scripted needs 180 ms for a decision on HandOff on this machine, and a tick has 100 ms: take a faster machine or "
    "another partner; with study serve --slow-agents it plays all the same, and misses ticks"
)


@pytest.fixture
def timed(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, str]]:
    """The agents and maps that were timed: `scripted` takes 180 ms."""
    asked: list[tuple[str, str]] = []

    def decision_ms(agent_id: str, the_map: str) -> float:
        asked.append((agent_id, the_map))
        return 180.0 if agent_id == "scripted" else 100.0

    monkeypatch.setattr(partner_speed, "decision_ms", decision_ms)
    return asked


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "study.yaml"
    path.write_text(SMALL, encoding="utf-8")
    return path


def test_check_times_each_partner_on_a_map_that_it_is_met_on_and_one_that_is_too_slow_is_a_fault(
    timed: list[tuple[str, str]], file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", "check", str(file), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert (document["slow"], document["ready"], document["missing"]) == ([SLOW], False, [])
    assert timed == [("scripted", "HandOff"), ("idle", "HandOff")]
    main(["study", "check", str(file)])
    page = capsys.readouterr().out
    assert f"too slow: {SLOW}" in page and "1 agent too slow" in page


def test_for_a_server_that_lets_slow_agents_play_such_a_partner_is_a_warning(
    timed: list[tuple[str, str]], file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["study", "check", str(file), "--slow-agents", "--json"])
    document = json.loads(capsys.readouterr().out)
    assert document["slow"] == [] and SLOW in document["warnings"] and timed
    main(["study", "check", str(file), "--slow-agents"])
    assert f"warning: {SLOW}" in capsys.readouterr().out


def test_an_agent_that_is_not_ready_in_time_is_too_slow_and_one_that_is_not_timed_is_not(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def decision_ms(agent_id: str, the_map: str) -> None:
        if agent_id == "scripted":
            raise NotReadyError("the partner scripted was not ready within 90 s")

    monkeypatch.setattr(partner_speed, "decision_ms", decision_ms)
    assert partner_speed.slow_partners(read_study(file)) == (
        "the partner scripted was not ready within 90 s: take a faster machine or another partner; study serve "
        "--slow-agents begins all the same, but its rounds wait for it no longer than that",
    )
