"""What training all agents would run."""

import shlex

import pytest

from bench import train_agents


def test_the_clones_of_the_family_are_trained_when_asked_for_and_nothing_else(
    capsys: pytest.CaptureFixture[str],
) -> None:
    train_agents.main(["--clones", "--dry-run"])
    commands = [shlex.split(line) for line in capsys.readouterr().out.splitlines()]
    ids = [words[words.index("--id") + 1] for words in commands]
    assert ids == [f"clone-{seed}-{age}@families" for seed in range(3) for age in ("young", "old")]
