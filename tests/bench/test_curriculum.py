"""What is trained for the tables: everybody once, from what the tables say."""

import argparse
from collections import defaultdict
from pathlib import Path

import pytest

from bench import _curriculum
from bench._roster import AUGMENTED, DP, FIRST, LEARNER, OF_A, OF_BOTH, PLAIN


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, list[list[str]]]:
    """The commands of a whole curriculum, which are not run: by the agent to train, the others by their first word."""
    said: dict[str, list[list[str]]] = defaultdict(list)

    def note(_args: argparse.Namespace, agent_id: str, *words: object) -> None:
        said[agent_id].append([str(word) for word in words])

    def note_other(*words: object) -> None:
        said[str(words[0])].append([str(word) for word in words])
        Path(str(words[-1])).mkdir(parents=True)

    monkeypatch.setattr(_curriculum, "_command", note)
    monkeypatch.setattr(_curriculum, "_movingout", note_other)
    sizes = dict.fromkeys(
        ("episodes", "updates", "policy_updates", "simulator_updates", "baseline_updates", "plays"), 4
    )
    _curriculum.train_all(argparse.Namespace(data=tmp_path, rounds=1, width=8, batch=8, ticks=9, workers=2, **sizes))
    return said


def test_everybody_in_the_tables_is_trained(commands: dict[str, list[list[str]]]) -> None:
    learners = {agent_id.partition(":")[0] for field in (OF_BOTH, OF_A) for agent_id in field.learners}
    assert learners | {FIRST, LEARNER, "demos", "match"} == set(commands)


def test_who_is_trained_with_people_of_a_alone_sees_no_episode_of_others(
    commands: dict[str, list[list[str]]], tmp_path: Path
) -> None:
    folders = {words[words.index("--population") + 1]: Path(words[-1]).parent for words in commands["demos"]}
    assert folders == {"A": tmp_path / "labels" / "a", "B": tmp_path / "labels" / "b"}
    for agent_id in OF_A.learners:
        for words in commands[agent_id]:
            seen = [word for word in words if word.startswith(str(tmp_path))]
            assert seen == ([] if "--simulator" in words else [str(folders["A"])])
            assert not any(word.endswith("@all") for word in words)


def test_the_value_is_learned_again_from_what_it_led_to(commands: dict[str, list[list[str]]], tmp_path: Path) -> None:
    (first,), (again,) = commands[FIRST], commands[PLAIN]
    own_play = str(tmp_path / "plays" / "bass-first-all")
    assert own_play in again and own_play not in first


def test_the_policy_of_the_rounds_goes_on_with_more_labels(commands: dict[str, list[list[str]]]) -> None:
    assert len(commands[LEARNER]) == 1 and "--go-on" in commands[LEARNER][0]


def test_who_is_compared_learns_equally_long_from_the_same(commands: dict[str, list[list[str]]]) -> None:
    """The policy of the rounds saw fewer labels at first: it is nobody to compare others with."""
    plain, augmented = ([words[: words.index("--population")] for words in commands[one]] for one in (DP, AUGMENTED))
    assert plain == augmented
    assert [words[words.index("--learner") + 1] for words in commands["demos"]][2:] == [LEARNER] * 2


def test_a_training_that_fails_ends_with_its_last_words(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"mlp@all: training ended with 2: [^$]*name recordings to learn from"):
        _curriculum._command(argparse.Namespace(data=tmp_path), "mlp@all", "train", "mlp")
