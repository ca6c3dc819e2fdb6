"""The recipe of the agents that play anywhere: what is trained, from what, and in which order.

Maps without end instead of the paper's twelve, partners of many makes instead of one house's people, and observations
without absolute places. `recipe_anywhere` reads from top to bottom like `curriculum.recipe`; what has been done is
skipped.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from movingout.agents.checkpoint.checkpoint import CARD, find_checkpoint, folder_name
from movingout.agents.curriculum.steps import Stage, TrainingStep, count_option
from movingout.agents.data.dagger import EXPERT
from movingout.maps.generated.proved import read_table
from movingout.world.constants import LIMIT_TICKS

DP_ANY, LEARNER_ANY = "dp@any", "dp-rounds@any"
RESPONSE_ANY = "dp-response@any"  # DP_ANY, steered by reinforcement learning
BASS_ANY, FIRST_ANY = "bass@any", "bass-first@any"  # the first has a value that has not seen itself play yet
NAMES = {
    DP_ANY: "Diffusion Policy, any map",
    LEARNER_ANY: "Diffusion Policy, any map, between the rounds",
    RESPONSE_ANY: "Best response, any map",
    BASS_ANY: "DP/BASS, any map",
    FIRST_ANY: "DP/BASS, any map, its first value",
}
SEEN = "--layout", "relative-v1", "--lags", "3,10,30"


@dataclass(frozen=True, kw_only=True)
class AnywhereSizes:
    """How much is played and trained. The counts are options of `bench.train_anywhere`."""

    data: Path = Path("data")
    workers: int = 1  # processes, and trainings at a time
    ticks: int = LIMIT_TICKS  # limit of an episode
    partners: str = "families"  # who plays beside the expert and the learner: a word of `demos label --population`
    paper_maps: bool = False  # whether the paper's twelve are trained on too, in all symmetries
    maps: int = count_option(600, "generated maps of each mode to train on")
    rounds: int = count_option(3, "of labelling where the learner went", 0)
    updates: int = count_option(2500, "of the policy between rounds, after each of them")
    policy_updates: int = count_option(20000, "of Diffusion Policy on all labels")
    batch: int = count_option(512, "windows per update")
    width: int = count_option(384, "of Diffusion Policy: units per layer")
    response_rounds: int = count_option(0, "of reinforcement learning; needs the extra `rl`", 0)
    play_maps: int = count_option(300, "of these maps that agents play without the expert, for the value of BASS")
    value_updates: int = count_option(2400, "of the value of BASS")
    seeds: int = count_option(1, "trainings of Diffusion Policy on all labels, with seeds 0, 1, …")


def recipe_anywhere(sizes: AnywhereSizes) -> list[Stage]:
    """Maps, labels and agents, from nothing."""
    labels, listed = sizes.data / "anywhere" / "labels", sizes.data / "anywhere" / "maps.txt"
    stages: list[Stage] = [(_maps(sizes, listed),)]
    for number in range(sizes.rounds + 1):
        stages += [(step,) for step in _label(sizes, labels, listed, number)]
        if number < sizes.rounds:
            stages.append((_diffusion(sizes, LEARNER_ANY, labels, sizes.updates * (number + 1), 0),))
    ids = [DP_ANY, *(f"{DP_ANY}-{seed}" for seed in range(1, sizes.seeds))]
    stages.append(tuple(_diffusion(sizes, name, labels, sizes.policy_updates, seed) for seed, name in enumerate(ids)))
    return [*stages, *_response(sizes, listed), *_bass(sizes, labels, listed)]


def _response(sizes: AnywhereSizes, listed: Path) -> list[Stage]:
    """Reinforcement learning on the leash of the imitated policy, reported apart from it; none for 0 rounds."""
    partners = [f"people:{name}" for name in sizes.partners] if set(sizes.partners) <= set("AB") else [sizes.partners]
    words = (
        "train", "response", "--base", DP_ANY, "--map", f"@{listed}", "--partners", *partners, "--ticks", sizes.ticks,
        "--updates", sizes.response_rounds, "--threads", sizes.workers,
    )  # fmt: skip
    return [(_training(sizes, RESPONSE_ANY, words),)] if sizes.response_rounds else []


def _bass(sizes: AnywhereSizes, labels: Path, listed: Path) -> list[Stage]:
    """A value, learned from labels and own play; then again, from what it led to. The engine itself simulates."""
    own, led_to = (sizes.data / "anywhere" / "plays" / folder_name(name) for name in (DP_ANY, FIRST_ANY))
    shape = (
        "--dynamics", "engine", "--value-layout", "relative-v1", "--caution", 1, "--own", 4, "--partner", 2,
        "--value-updates", sizes.value_updates, "--threads", sizes.workers,
    )  # fmt: skip
    first = _training(sizes, FIRST_ANY, ("train", "bass", labels, own, "--base", DP_ANY, *shape))
    last = _training(sizes, BASS_ANY, ("train", "bass", labels, own, led_to, "--base", DP_ANY, *shape))
    alone, again = (_plays(sizes, DP_ANY, own, listed),), (_plays(sizes, FIRST_ANY, led_to, listed),)
    return [alone, (first,), again, (last,)]


def _plays(sizes: AnywhereSizes, agent_id: str, folder: Path, listed: Path) -> TrainingStep:
    """Episodes in which an agent plays and nobody helps it: it is its own expert, with occasional slips of its hand."""
    words = (
        "demos", "label", "--map", f"@{listed}:{min(sizes.play_maps, 3 * sizes.maps)}", "--learner", agent_id,
        "--expert", agent_id, "--population", sizes.partners, "--episodes", 1, "--seed", 100, "--ticks", sizes.ticks,
        "--workers", sizes.workers, "--out", folder,
    )  # fmt: skip
    marker = folder / "done"
    return TrainingStep(tuple(map(str, words)), marker.exists, marker=marker)


def _training(sizes: AnywhereSizes, agent_id: str, words: tuple[object, ...]) -> TrainingStep:
    """Train an agent that is not there yet."""
    card = sizes.data / "models" / folder_name(agent_id) / CARD
    whole = (*words, "--id", agent_id, "--name", NAMES[agent_id], "--data", sizes.data)
    log = sizes.data / "logs" / f"{folder_name(agent_id)}.log"
    return TrainingStep(tuple(map(str, whole)), card.exists, agent_id=agent_id, log=log)


def _maps(sizes: AnywhereSizes, listed: Path) -> TrainingStep:
    """The list of maps on which a pair of experts delivers everything."""
    words = "demos", "prove", "--split", "training", "--count", sizes.maps, "--workers", sizes.workers, "--out", listed
    return TrainingStep(tuple(map(str, words)), lambda: len(read_table(listed)) >= 3 * sizes.maps)


def _label(sizes: AnywhereSizes, labels: Path, listed: Path, number: int) -> list[TrainingStep]:
    """A round of labelling: two episodes per map by the expert alone, then one per map by turns with the learner."""
    learner, episodes = (EXPERT, 2) if number == 0 else (LEARNER_ANY, 1)
    steps = []
    for name, maps in (("generated", f"@{listed}"), ("paper", "all,all:symmetries")):
        folder = labels / f"{name}-{number}"
        words = (
            "demos", "label", "--map", maps, "--learner", learner, "--population", sizes.partners,
            "--episodes", episodes, "--seed", number, "--ticks", sizes.ticks, "--workers", sizes.workers,
            "--out", folder,
        )  # fmt: skip
        marker = folder / "done"
        if name == "generated" or sizes.paper_maps:
            steps.append(TrainingStep(tuple(map(str, words)), marker.exists, marker=marker))
    return steps


def _diffusion(sizes: AnywhereSizes, agent_id: str, labels: Path, total: int, seed: int) -> TrainingStep:
    """Diffusion Policy, trained on to `total` updates with the labels there are by now."""
    whole = (
        "train", "dp", labels, "--id", agent_id, "--name", NAMES.get(agent_id, f"{NAMES[DP_ANY]}, seed {seed}"), *SEEN,
        "--go-on", "--updates", total, "--width", sizes.width, "--batch", sizes.batch, "--seed", seed,
        "--threads", sizes.workers if agent_id == LEARNER_ANY or sizes.seeds == 1 else 1, "--data", sizes.data,
        "--population", f"a scripted expert beside {sizes.partners} on generated maps",
    )  # fmt: skip
    log = sizes.data / "logs" / f"{folder_name(agent_id)}.log"
    return TrainingStep(tuple(map(str, whole)), _trained(sizes.data / "models", agent_id, total), None, agent_id, log)


def _trained(models: Path, agent_id: str, total: int) -> Callable[[], bool]:
    def is_done() -> bool:
        there = (models / folder_name(agent_id) / CARD).exists()
        return there and find_checkpoint(agent_id, models).card.training.updates >= total

    return is_done
