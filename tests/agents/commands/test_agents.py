"""`movingout agents` as somebody at a terminal sees it."""

import json
import re
import sys
from pathlib import Path

import pytest

from movingout.agents.catalogue import UNSEEN_NFD, UNSEEN_TCR, agent_cards, load_agent
from movingout.agents.checkpoint.checkpoint import SHIPPED
from movingout.agents.commands import agents
from movingout.agents.conformance import ConformanceError
from movingout.agents.llm.first_answer import first_answer
from movingout.maps import load_map, map_to_json
from movingout.server.cli import main
from tests.agents.llm.stand_in import Reply, said, stand_in

PRINTING = """
import numpy as np

print("imported")


class Printing:
    def __init__(self):
        print("made")

    def reset(self, episode):
        print("reset")

    def act(self, observation):
        print("asked")
        return np.array([[0.0, 1.0, 0.0, 0.0]])
"""


def test_the_list_has_the_scores_of_the_cards_in_columns(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["agents", "list"]) == 0
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.split()[:5] == ["agent", "kind", "maps", "TCR", "NFD"]
    shown = {row.split()[0]: row.split()[3:5] for row in rows if row and not row.startswith(" ")}
    for card in agent_cards():
        scores = [card.scores.get(name) for name in (UNSEEN_TCR, UNSEEN_NFD)]
        assert shown[card.id] == ["–" if score is None else f"{score:.2f}" for score in scores]


def test_the_list_has_every_agent(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["agents", "list"]) == 0
    printed = capsys.readouterr().out
    assert all(card.id in printed for card in agent_cards())
    assert main(["agents", "list", "--json"]) == 0
    assert [card["id"] for card in json.loads(capsys.readouterr().out)["agents"]] == [card.id for card in agent_cards()]


@pytest.mark.parametrize("columns", [40, 60, 75, 80, 120])
def test_every_id_of_the_list_and_every_word_is_whole_in_any_terminal(
    columns: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    assert main(["agents", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    cards = agent_cards()
    firsts = [line.split()[0] for line in lines if line and not line.startswith(" ")]
    assert [word for word in firsts if word in {card.id for card in cards}] == [card.id for card in cards]
    assert {word for card in cards for word in card.description.split()} <= {
        word for line in lines for word in line.split()
    }
    assert max(map(len, lines)) <= columns


def test_one_agent_is_shown_and_an_unknown_one_is_answered_with_those_there_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["agents", "show", "idle"]) == 0
    assert "Does nothing" in capsys.readouterr().out
    assert main(["agents", "show", "scriptet"]) == 2
    assert "known: scripted" in capsys.readouterr().err


def test_a_trained_agent_is_shown_with_what_its_networks_take_and_give(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["agents", "show", "bass@any:score=value"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert f"folder: {SHIPPED / 'bass-any'}" in lines
    assert "policy.onnx: observation (batch, 1, 491), noise (batch, 1, 8, 5) → chunk (batch, 8, 5)" in lines
    assert "value.onnx: features (batch, 383) → value (batch, 3)" in lines
    assert main(["agents", "show", "mlp@all"]) == 0
    assert "policy.onnx: observation (batch, 1, 278) → chunk (batch, any, any)" in capsys.readouterr().out
    assert main(["agents", "show", "mlp@all", "--json"]) == 0
    [network] = json.loads(capsys.readouterr().out)["networks"].values()
    assert list(network["inputs"]) == ["observation"] and list(network["outputs"]) == ["chunk"]
    assert main(["agents", "show", "idle", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["networks"] == {}


@pytest.mark.parametrize(
    ("agent_id", "sentence"),
    [
        ("mlp@all:foo=3", "unexpected keyword argument 'foo'; options: execute"),
        ("mlp@all:sampling=4", "unexpected keyword argument 'sampling'; options: execute"),
        ("mlp@all:execute=-3", "execute is a whole number of ticks from 1 to 8, not -3"),
        ("mlp@all:execute=2.5", "execute is a whole number of ticks from 1 to 8, not 2.5"),
        ("mlp@all:execute=abc", "execute is a whole number of ticks from 1 to 8, not abc"),
        ("mlp@all:execute=9", "execute is a whole number of ticks from 1 to 8, not 9"),
        ("mlp@all:lag=99", "lag is a whole number of ticks from 1 to 10, not 99"),
        ("bass@all:simulator=0", "simulator=learned, engine or oracle"),
        ("person:name=Z01", "there is no person 'Z01'"),
        ("scripted:patience=abc", "style: patience must lie between"),
    ],
)
def test_options_that_cannot_be_are_refused_when_an_agent_is_shown(
    agent_id: str, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["agents", "show", agent_id]) == 2
    captured = capsys.readouterr()
    assert sentence in captured.err and captured.out == "" and "Error" not in captured.err


def test_an_agent_is_shown_with_options_that_it_takes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["agents", "show", "mlp@all:execute=8,lag=1"]) == 0
    assert "MLP" in capsys.readouterr().out


def test_a_probe_on_a_map_that_was_never_seen_says_so_beside_its_answer(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["agents", "probe", "mlp@all", "--map", "Simple", "--ticks", "2", "--json"]) in (0, 1)
    printed = capsys.readouterr()
    assert printed.err.count("mlp@all has never seen the map Simple") == 1
    assert json.loads(printed.out)["map"] == "Simple"


def test_an_oracle_is_probed_with_the_world_that_it_needs(capsys: pytest.CaptureFixture[str]) -> None:
    """It was refused as one for headless matches, which a probe is like."""
    command = ["agents", "probe", "bass@all:simulator=oracle", "--map", "HandOff", "--ticks", "2", "--json"]
    assert main(command) in (0, 1)
    assert json.loads(capsys.readouterr().out)["ticks"] == 2


def test_a_probe_of_an_agent_that_raises_says_where(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = (
        "class Raising:",
        "    def reset(self, episode):",
        "        pass",
        "    def act(self, seen):",
        "        1 / 0",
    )
    (tmp_path / "raising_agent.py").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(tmp_path)
    assert main(["agents", "probe", "raising_agent:Raising", "--ticks", "5"]) == 2
    said = capsys.readouterr().err
    assert (
        "raising_agent:Raising raised ZeroDivisionError: division by zero (" in said
        and "raising_agent.py, line 5)" in said
    )


def test_a_probe_ends_by_ctrl_c_but_not_by_what_an_agent_raises(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = (
        "import signal",
        "class Interrupting:",
        "    def reset(self, episode):",
        "        pass",
        "    def act(self, seen):",
        "        raise KeyboardInterrupt('mine')",
        "class Pressed(Interrupting):",
        "    def act(self, seen):",
        "        signal.raise_signal(signal.SIGINT)",
    )
    (tmp_path / "interrupting_agent.py").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(tmp_path)
    assert main(["agents", "probe", "interrupting_agent:Interrupting", "--ticks", "5"]) == 2
    assert "interrupting_agent:Interrupting raised KeyboardInterrupt: mine (" in capsys.readouterr().err
    assert main(["agents", "probe", "interrupting_agent:Pressed", "--ticks", "5"]) == 130


@pytest.mark.parametrize("action", ["probe", "check"])
def test_a_map_that_is_delivered_from_the_start_is_refused(
    action: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing was decided on it, and the percentiles of no times ended in a traceback."""
    goals = [{"x0": -1.2, "y0": 1.2, "x1": 1.2, "y1": -1.2}]
    document = map_to_json(load_map("Simple")) | {"name": "Done", "goals": goals}
    (tmp_path / "done.json").write_text(json.dumps(document))
    assert main(["agents", action, "idle", "--map", str(tmp_path / "done.json"), "--ticks", "5"]) == 2
    assert "on Done all items lie in a goal from the start, so there is nothing to play" in capsys.readouterr().err


def test_a_probe_times_the_decisions(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["agents", "probe", "idle", "--ticks", "5", "--json"]) == 0
    probe = json.loads(capsys.readouterr().out)
    assert (probe["id"], probe["ticks"], probe["threads"], probe["holds_10hz"]) == ("idle", 5, 1, True)
    assert 1 <= probe["decision_ms"]["n"] <= 5
    assert 0 <= probe["decision_ms"]["p50"] <= probe["decision_ms"]["p99"]


@pytest.mark.parametrize(
    "command",
    [
        ["agents", "show"],
        ["agents", "probe", "--ticks", "3"],
        ["agents", "check", "--ticks", "3", "--map", "HandOff"],
        ["match", "--map", "HandOff", "--ticks", "3", "--blue", "idle", "--red"],
        ["demos", "label", "--map", "HandOff", "--ticks", "3", "--workers", "1", "--out", "labels", "--learner"],
    ],
)
def test_what_an_agent_prints_is_no_part_of_the_document_on_standard_output(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "printing_policy.py").write_text(PRINTING, encoding="utf-8")
    monkeypatch.delitem(sys.modules, "printing_policy", raising=False)
    main([*command, "printing_policy:Printing", "--json"])
    captured = capfd.readouterr()
    json.loads(captured.out)
    assert "imported" in captured.err and "made" in captured.err


@pytest.mark.parametrize("around", ["{}", "late:agent={}"])
def test_a_check_asks_a_language_model_one_real_question(around: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A check that waits for no answer has checked the fallback alone, and said that all is well."""
    replies = [said(json.dumps({"plan": "I wait here.", "skills": [{"skill": "wait"}]}))]
    with stand_in(lambda _: replies[-1]) as server:
        model = f"llm:model=m,url={server.url}"
        agent = around.format(model.replace(",", ";") if around.startswith("late") else model)
        check = ["agents", "check", agent, "--map", "HandOff", "--ticks", "2"]
        assert main(check) == 0
        printed = capsys.readouterr().out
        assert re.match(r"Its model answered a question in \d+\.\d s: I wait here\.\n", printed)
        assert main([*check, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["answer_s"] >= 0.0
        for reply, problem in (
            (Reply("oops \x1b[2J", 500), "HTTP 500: oops �[2J)"),
            (said("I would rather talk."), "it has no JSON object"),
        ):
            replies.append(reply)
            assert main(check) == 1
            assert f"{agent}: its model gave no usable answer to 3 questions ({problem}" in capsys.readouterr().out


def test_a_check_asks_again_and_checks_the_rules_all_the_same(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A server that loads its model at the first question is too late for that one alone."""
    good = said(json.dumps({"plan": "I wait here.", "skills": [{"skill": "wait"}]}))
    replies = [Reply("loading", 503), good]
    with stand_in(lambda _: replies.pop(0) if len(replies) > 1 else replies[0]) as server:
        answered = first_answer(load_agent(agent_id := f"llm:model=m,url={server.url}"), "HandOff")
        assert answered is not None and (answered.plan, answered.problem) == ("I wait here.", "")
        replies[:] = [Reply("gone", 503)]

        def broken(*_: object) -> None:
            raise ConformanceError("act() returned NaN")

        monkeypatch.setattr(agents, "check_agent", broken)
        assert main(["agents", "check", agent_id]) == 1
        problem = "no usable answer to 3 questions (HTTP 503: gone); act() returned NaN"
        assert problem in capsys.readouterr().out


def test_a_check_does_not_wait_for_a_model_that_gave_no_answer(capsys: pytest.CaptureFixture[str]) -> None:
    """It waited for each of a hundred questions, and called the model's silence a broken rule besides."""
    with stand_in(lambda _: said("I would rather talk.")) as server:
        agent = f"llm:model=m,url={server.url},wait=yes"
        assert main(["agents", "check", agent, "--map", "HandOff"]) == 1
        assert len(server.requests) == 3 and "act raised" not in capsys.readouterr().out
