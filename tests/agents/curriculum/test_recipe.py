"""What is trained for the tables: everybody once, from what the tables say."""

from collections import defaultdict
from pathlib import Path

import pytest

from bench._roster import OF_A, OF_BOTH
from movingout.agents.checkpoint.checkpoint import ships
from movingout.agents.curriculum.recipe import Sizes, recipe
from movingout.agents.curriculum.roster import AUGMENTED, DP, FIRST, LEARNER, PLAIN
from movingout.agents.curriculum.steps import TrainingStep, run_stages, run_step

Commands = dict[str, list[tuple[str, ...]]]


@pytest.fixture
def commands(tmp_path: Path) -> Commands:
    """The commands of a whole recipe: by the agent to train, the others by their first word."""
    found: Commands = defaultdict(list)
    for stage in recipe(Sizes(data=tmp_path, rounds=1, workers=2)):
        for step in stage:
            found[step.agent_id or step.words[0]].append(step.words)
    return found


def _option(words: tuple[str, ...], name: str) -> str:
    return words[words.index(name) + 1]


def test_everybody_in_the_tables_is_trained(commands: Commands) -> None:
    learners = {agent_id.partition(":")[0] for field in (OF_BOTH, OF_A) for agent_id in field.learners}
    assert learners | {FIRST, LEARNER, "demos", "match"} == set(commands)


def test_agents_that_ship_are_trained_on_purpose(commands: Commands) -> None:
    shipped = [agent_id for agent_id in commands if ships(agent_id)]
    assert shipped and all("--instead-of-shipped" in words for one in shipped for words in commands[one])


def test_who_is_trained_with_people_of_a_alone_sees_no_episode_of_others(commands: Commands, tmp_path: Path) -> None:
    folders = {_option(words, "--population"): Path(words[-1]).parent for words in commands["demos"]}
    assert folders == {"A": tmp_path / "labels" / "a", "B": tmp_path / "labels" / "b"}
    for agent_id in OF_A.learners:
        for words in commands[agent_id]:
            assert words[-2:] == ("--data", str(tmp_path))
            seen = [word for word in words[:-2] if word.startswith(str(tmp_path))]
            assert seen == ([] if "--simulator" in words else [str(folders["A"])])
            assert not any(word.endswith("@all") for word in words)


def test_the_value_is_learned_again_from_what_it_led_to(commands: Commands, tmp_path: Path) -> None:
    (first,), (again,) = commands[FIRST], commands[PLAIN]
    own_play = str(tmp_path / "plays" / "bass-first-all")
    assert own_play in again and own_play not in first


def test_the_policy_of_the_rounds_goes_on_with_more_labels(commands: Commands) -> None:
    assert len(commands[LEARNER]) == 1 and "--go-on" in commands[LEARNER][0]


def test_who_is_compared_learns_equally_long_from_the_same(commands: Commands) -> None:
    """The policy of the rounds saw fewer labels at first: it is nobody to compare others with."""
    plain, augmented = ([words[: words.index("--population")] for words in commands[one]] for one in (DP, AUGMENTED))
    assert plain == augmented
    assert [_option(words, "--learner") for words in commands["demos"]][2:] == [LEARNER] * 2


@pytest.mark.slow
def test_a_training_that_fails_ends_with_its_last_words(tmp_path: Path) -> None:
    step = TrainingStep(
        ("train", "mlp"), is_done=lambda: False, agent_id="mlp@all", log=tmp_path / "logs" / "mlp-all.log"
    )
    with pytest.raises(SystemExit, match=r"mlp@all: training ended with 2: [^$]*name recordings to learn from"):
        run_step(step)


def test_what_is_done_is_skipped_and_what_succeeds_is_marked(tmp_path: Path) -> None:
    marker = tmp_path / "done"
    step = TrainingStep(("maps", "list", "--json"), marker.exists, marker=marker)
    run_stages([(step,)], at_once=1)
    assert marker.exists()
    run_step(TrainingStep(("no-such-command",), marker.exists))
