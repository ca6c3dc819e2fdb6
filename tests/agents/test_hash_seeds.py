"""An agent whose decisions depend on the seed of `hash`, which is another one in each process."""

import re
from pathlib import Path

import pytest

from movingout.agents.hash_seeds import process_problem
from movingout.server.cli import main

HASHING = """
import numpy as np


class Agent:
    def reset(self, episode):
        pass

    def act(self, observation):
        return np.array([[0.0, {heading}, 0.0, 0.0]])


class OtherAgent(Agent):
    deterministic = False
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path / "hashing_policy.py"


def test_a_check_names_an_agent_that_decides_otherwise_in_another_process(
    module: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It met the rules, though no match of it can be played again."""
    module.write_text(HASHING.format(heading="(hash('x') % 7 + 1) / 8"), encoding="utf-8")
    short = ["--map", "HandOff", "--ticks", "3"]
    assert main(["agents", "check", "hashing_policy:Agent", *short]) == 1
    said = "hashing_policy:Agent: HandOff, blue: decision 1 is another in another process, for the same map, seat and"
    assert said in capsys.readouterr().out
    assert main(["agents", "check", "hashing_policy:OtherAgent", *short]) == 0
    assert "it is not deterministic" in capsys.readouterr().out


@pytest.mark.parametrize(("heading", "problem"), [("0.5", ""), ("1 / 0", "it ended with 1: movingout: .*ZeroDivision")])
@pytest.mark.slow
def test_one_that_decides_alike_has_no_problem_and_one_that_fails_there_is_named(
    heading: str, problem: str, module: Path
) -> None:
    module.write_text(HASHING.format(heading=heading), encoding="utf-8")
    assert re.search(problem or "^$", process_problem("hashing_policy:Agent", "HandOff", 2))
