"""The tables about the parts of BASS: the paper's figures of the right challenge, and ours where the agent is that."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from bench import bass
from bench.bass import main
from bench.results import bass_tables
from bench.results.bass_tables import BASS, GRU, ORACLE, RANDOM, role, tables
from movingout.agents.bass.accuracy import BassAccuracy
from movingout.agents.checkpoint.card import DynamicsSpec
from tests.agents.learning import recorded


def test_the_paper_s_rows_hold_its_figures_for_the_challenge_and_ours_where_the_agent_is_that() -> None:
    numbers = dict.fromkeys(BassAccuracy.__slots__, 0.5)
    rows = tables({"b": numbers, "r": numbers}, {"b": BASS, "r": RANDOM}, 2).splitlines()
    assert "| Challenge 2 | paper | b | r |" in rows
    assert "| BASS | 0.0028 | 0.5000 | 0.5000 |" in rows
    assert "| BASS | 0.4870 | 0.5000 |  |" in rows
    assert "| BASS (Random partner action) | 0.2484 |  | 0.5000 |" in rows
    assert "| BASS (qVAE) | 0.2722 |  |  |" in rows


def test_agents_are_called_what_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    ids = ["bass@all:lag=0", "bass@all:partner=random", "bass@all:simulator=oracle"]
    agents = {agent_id: bass.bass_agent_of(agent_id) for agent_id in ids}
    assert [role(*each) for each in agents.items()] == [BASS, RANDOM, ORACLE]
    card = SimpleNamespace(dynamics=DynamicsSpec(kind="gru"))
    monkeypatch.setattr(bass_tables, "find_checkpoint", lambda *_: SimpleNamespace(card=card))
    assert role(ids[0], agents[ids[0]]) == GRU


def test_the_command_prints_a_column_for_each_agent(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recorded(tmp_path, "one", ticks=20)
    command = ["--data", str(tmp_path), "--moments", "1", "--agents", "bass@all", "bass@all:score=nfd,sampling=4x4"]
    main(command)
    shown = capsys.readouterr().out
    assert "| Challenge 1 | paper | bass@all | bass@all:score=nfd,sampling=4x4 |" in shown
    assert "| BASS (GRU) | 0.2487 |  |  |" in shown and "| moments |  | 1 | 1 |" in shown
    main([*command, "--json"])
    assert set(json.loads(capsys.readouterr().out)["agents"]) == set(command[-2:])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--agents", "bass@nowhere"], "no checkpoint"),
        (["--agents", "dp@all"], "dp@all is not a BASS agent"),
        (["--agents", "bass@all:sampling=9"], "sampling is one of"),
        (["--moments", "0"], "--moments, --ticks and --workers must be at least 1"),
        (["--seed", "-1"], "--seed at least 0"),
        (["--data", "nowhere"], "there is no recording at nowhere"),
        (["--challenge", "2"], "a recording has HandOff as designed, which is not Challenge 2"),
    ],
)
def test_what_cannot_be_measured_is_refused_in_a_sentence(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded(tmp_path, "one", ticks=9)
    with pytest.raises(SystemExit) as ended:
        main(["--data", str(tmp_path), *words])
    assert ended.value.code == 2 and said in capsys.readouterr().err
