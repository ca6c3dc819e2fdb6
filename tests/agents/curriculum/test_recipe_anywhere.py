"""What is trained to play anywhere: on training seeds alone, on all labels, and what is done is not done again."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from movingout.agents.checkpoint.checkpoint import SHIPPED, find_checkpoint, ships
from movingout.agents.curriculum.recipe_anywhere import (
    BASS_ANY,
    DP_ANY,
    FIRST_ANY,
    LEARNER_ANY,
    RESPONSE_ANY,
    AnywhereSizes,
    recipe_anywhere,
)
from movingout.agents.curriculum.steps import TrainingStep
from movingout.agents.kinds.bass import BASS


def steps(folder: Path, **changes: object) -> list[TrainingStep]:
    sizes = AnywhereSizes(**{"data": folder, "rounds": 1, "maps": 2, **changes})  # type: ignore[arg-type]
    return [step for stage in recipe_anywhere(sizes) for step in stage]


def option(step: TrainingStep, name: str) -> str:
    return step.words[step.words.index(name) + 1]


def test_maps_are_those_of_the_training_seeds_and_every_round_is_played_on_them(tmp_path: Path) -> None:
    proving, first, learner, second, policy, *_ = steps(tmp_path)
    listed = str(tmp_path / "anywhere" / "maps.txt")
    assert (option(proving, "--split"), option(proving, "--out")) == ("training", listed)
    assert option(first, "--map") == option(second, "--map") == f"@{listed}"
    assert option(second, "--learner") == LEARNER_ANY
    assert (learner.agent_id, policy.agent_id) == (LEARNER_ANY, DP_ANY)
    labels = tmp_path / "anywhere" / "labels"
    assert policy.words[:3] == ("train", "dp", str(labels)) and option(policy, "--layout") == "relative-v1"
    assert {Path(option(step, "--out")).parent for step in (first, second)} == {labels}


def test_the_papers_maps_are_used_only_on_demand(tmp_path: Path) -> None:
    assert not any("all" in option(step, "--map").split(",") for step in steps(tmp_path) if "--map" in step.words)
    words = [option(step, "--map") for step in steps(tmp_path, paper_maps=True) if "--map" in step.words]
    assert words.count("all,all:symmetries") == 2


def test_several_seeds_are_several_agents(tmp_path: Path) -> None:
    trained = [step for step in steps(tmp_path, seeds=3) if step.agent_id.startswith(DP_ANY)]
    assert [(step.agent_id, option(step, "--seed")) for step in trained] == [
        ("dp@any", "0"), ("dp@any-1", "1"), ("dp@any-2", "2"),
    ]  # fmt: skip


def test_agents_that_ship_are_trained_on_purpose(tmp_path: Path) -> None:
    shipped = [step for step in steps(tmp_path) if ships(step.agent_id)]
    assert shipped and all("--instead-of-shipped" in step.words for step in shipped)


def test_the_value_is_learned_again_from_what_it_led_to(tmp_path: Path) -> None:
    made = {step.agent_id: step.words for step in steps(tmp_path) if step.agent_id}
    own_play = str(tmp_path / "anywhere" / "plays" / "bass-first-any")
    assert own_play in made[BASS_ANY] and own_play not in made[FIRST_ANY]
    played = [step for step in steps(tmp_path) if "--expert" in step.words]
    assert [(option(step, "--learner"), option(step, "--expert")) for step in played] == [
        (DP_ANY, DP_ANY), (FIRST_ANY, FIRST_ANY),
    ]  # fmt: skip


def test_bass_chooses_as_the_one_that_ships(tmp_path: Path) -> None:
    shipped = find_checkpoint(BASS_ANY, SHIPPED).card.selection
    assert shipped is not None
    trained = [step.words for step in steps(tmp_path) if step.words[1] == "bass"]
    for words in trained:
        given = {word[2:].replace("-", "_"): words[at + 1] for at, word in enumerate(words) if word.startswith("--")}
        told: dict[str, Any] = {
            name: float(given[name]) for name in ("own", "partner", "caution", "sub_steps") if name in given
        }
        assert replace(BASS.presets["fast"], dynamics="engine", **told).selection() == shipped
    assert len(trained) == 2


def test_reinforcement_learning_is_asked_for_and_steers_the_imitated_policy(tmp_path: Path) -> None:
    assert not any("response" in step.words for step in steps(tmp_path))
    [response] = [step for step in steps(tmp_path, response_rounds=5, partners="AB") if "response" in step.words]
    assert response.agent_id == RESPONSE_ANY and option(response, "--base") == DP_ANY
    assert response.words[response.words.index("--partners") + 1 :][:2] == ("people:A", "people:B")


def test_what_is_there_is_not_made_again(tmp_path: Path) -> None:
    proving, first, *_ = steps(tmp_path)
    assert not proving.is_done() and not first.is_done()
    (tmp_path / "anywhere").mkdir()
    names = [
        f"generated:{mode}:{seed} 100\n"
        for mode in ("coordination", "awareness", "consistency")
        for seed in (20000, 20001)
    ]
    (tmp_path / "anywhere" / "maps.txt").write_text("".join(names))
    assert proving.is_done()
    assert first.marker is not None
    first.marker.parent.mkdir(parents=True)
    first.marker.touch()
    assert first.is_done()


def test_each_seed_has_bass_on_its_own_policy(tmp_path: Path) -> None:
    made = [step for step in steps(tmp_path, seeds=3) if step.words[1] == "bass"]
    told = [(step.agent_id, option(step, "--base"), option(step, "--seed")) for step in made]
    assert [one for one in told if "first" not in one[0]] == [
        ("bass@any", "dp@any", "0"), ("bass@any-1", "dp@any-1", "1"), ("bass@any-2", "dp@any-2", "2"),
    ]  # fmt: skip
    assert [option(step, "--name") for step in made][-2:] == ["DP/BASS, any map, seed 1", "DP/BASS, any map, seed 2"]
    for step in made:
        plays = {Path(word).name for word in step.words if "plays" in word}
        seed = step.agent_id.partition("any")[2]
        assert plays == {f"dp-any{seed}"} | ({f"bass-first-any{seed}"} if "first" not in step.agent_id else set())


def test_another_number_of_rounds_of_reinforcement_learning_goes_on(tmp_path: Path) -> None:
    [response] = [step for step in steps(tmp_path, response_rounds=5) if "response" in step.words]
    assert "--go-on" in response.words and not response.is_done()
