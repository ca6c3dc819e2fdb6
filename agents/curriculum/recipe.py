"""The recipe of the shipped agents: what is trained, from what, and in which order.

`recipe` reads from top to bottom; each of its lines is a stage, a handful of `movingout` commands that may run at the
same time. A step that has been done is skipped, so the whole can be stopped and started again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from movingout.agents.checkpoint.checkpoint import CARD, folder_name
from movingout.agents.curriculum.roster import (
    AUGMENTED,
    AUGMENTED_A,
    BASS,
    BASS_A,
    DP,
    DP_A,
    FIRST,
    GRU,
    GRU_A,
    LEARNER,
    MLP,
    MLP_A,
    NAMES,
    PLAIN,
    PLAIN_A,
)
from movingout.agents.curriculum.steps import Stage, TrainingStep, count_option, trained
from movingout.agents.data.dagger import EXPERT
from movingout.world.constants import LIMIT_TICKS

AUGMENTATION = "--pose-noise", 0.002, "--recombine", 0.25  # paper, "Behavior Augmentation Details"
BY_NFD = "--score", "nfd", "--own", 4, "--partner", 4  # paper, 4 x 4 sampling


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """How much is played and trained. The counts are options of `bench.train_agents`."""

    data: Path = Path("data")
    workers: int = 1  # processes, and trainings at a time
    ticks: int = LIMIT_TICKS  # limit of an episode
    episodes: int = count_option(64, "per map in the expert's round; half in the others")
    rounds: int = count_option(2, "of labelling where the learner went", 0)
    updates: int = count_option(1200, "of the policy between rounds, after each of them")
    policy_updates: int = count_option(6000, "of Diffusion Policy on all labels; half with A's", 2)
    batch: int = count_option(512, "windows per update of Diffusion Policy")
    width: int = count_option(384, "of Diffusion Policy: units per layer")
    simulator_updates: int = count_option(5000, "of the simulator of BASS")
    plays: int = count_option(12, "episodes per map and population without the expert")
    baseline_updates: int = count_option(2000, "of MLP and GRU")


@dataclass(frozen=True, slots=True)
class LabelledData:
    """Labelled episodes to learn from, and whose they are."""

    folder: Path
    people: str  # for the card


def recipe(sizes: Sizes) -> list[Stage]:
    """Every agent of the tables, from nothing."""
    labels = sizes.data / "labels"
    both = LabelledData(labels, "a scripted expert beside scripted people of A and B; none of population C")
    of_a = LabelledData(labels / "a", "a scripted expert beside scripted people of A; none of populations B and C")
    train, diffusion = partial(_train, sizes), partial(_diffusion, sizes)
    simulator = "--updates", sizes.simulator_updates
    own_plays, bass_plays = (_plays_folder(sizes, agent_id) for agent_id in (DP, FIRST))
    alone = "--threads", sizes.workers  # of what has the machine to itself
    return [
        *_rounds(sizes, both),
        (
            diffusion(DP, both, sizes.policy_updates),
            diffusion(AUGMENTED, both, sizes.policy_updates, *AUGMENTATION),
            diffusion(DP_A, of_a, sizes.policy_updates // 2),  # half of the labels
            diffusion(AUGMENTED_A, of_a, sizes.policy_updates // 2, *AUGMENTATION),
        ),
        *_plays(sizes, DP),
        (
            train(FIRST, "bass", labels, own_plays, "--base", DP, *simulator),
            train(BASS_A, "bass", of_a.folder, "--base", AUGMENTED_A, *BY_NFD, *simulator),
            *_baselines(sizes, both, MLP, GRU),  # nothing waits for them: they fill what the first value leaves free
            *_baselines(sizes, of_a, MLP_A, GRU_A),
        ),
        *_plays(sizes, FIRST),
        (train(PLAIN, "bass", labels, own_plays, bass_plays, "--base", DP, "--simulator", FIRST, *alone),),
        (train(BASS, "bass", "--base", AUGMENTED, "--simulator", PLAIN, "--value", PLAIN),),
        (train(PLAIN_A, "bass", "--base", DP_A, "--simulator", BASS_A, *BY_NFD),),
    ]


def _rounds(sizes: Sizes, labelled: LabelledData) -> list[Stage]:
    """An expert labels, a learner learns from it; then it labels what the learner does, and so on (DAgger)."""
    stages: list[Stage] = []
    for number in range(sizes.rounds + 1):
        stages += [(_label(sizes, labelled.folder, people, number),) for people in "AB"]
        if number < sizes.rounds:
            total = sizes.updates * (number + 1)
            stages.append((_diffusion(sizes, LEARNER, labelled, total, "--threads", sizes.workers),))
    return stages


def _label(sizes: Sizes, labels: Path, people: str, number: int) -> TrainingStep:
    """A round of labelling beside the people of one population; the learner is a policy of both."""
    folder = labels / people.lower() / f"round-{number}"
    learner, count = (EXPERT, sizes.episodes) if number == 0 else (LEARNER, max(sizes.episodes // 2, 1))
    words = (
        "demos", "label", "--learner", learner, "--population", people, "--episodes", -(-count // 2), "--seed", number,
        "--ticks", sizes.ticks, "--workers", sizes.workers, "--out", folder,
    )  # fmt: skip
    return _marked(folder / "done", words)


def _diffusion(sizes: Sizes, agent_id: str, labelled: LabelledData, total: int, *words: object) -> TrainingStep:
    """Diffusion Policy, trained on to `total` updates with the labels there are by now."""
    shape = "--go-on", "--updates", total, "--width", sizes.width, "--batch", sizes.batch
    whole = "train", "dp", labelled.folder, *shape, "--population", labelled.people, *words
    return _training(sizes, agent_id, whole, trained(sizes.data / "models", agent_id, total))


def _baselines(sizes: Sizes, labelled: LabelledData, mlp: str, gru: str) -> Stage:
    """The paper's two baselines from the same labelled, the longer one first."""
    words = labelled.folder, "--population", labelled.people, "--updates", sizes.baseline_updates
    return _train(sizes, gru, "gru", *words), _train(sizes, mlp, "mlp", *words)


def _plays_folder(sizes: Sizes, agent_id: str) -> Path:
    return sizes.data / "plays" / folder_name(agent_id)


def _plays(sizes: Sizes, agent_id: str) -> list[Stage]:
    """Episodes in which an agent plays with people of A and B, in either seat, and nobody helps it."""
    folder = _plays_folder(sizes, agent_id)
    stages: list[Stage] = []
    for number, (people, red) in enumerate((people, red) for people in "AB" for red in (True, False)):
        seats = (agent_id, f"people:{people}") if red else (f"people:{people}", agent_id)
        words = (
            "match", "--red", seats[0], "--blue", seats[1], "--episodes", -(-sizes.plays // 2), "--seed", 1000 * number,
            "--ticks", sizes.ticks, "--workers", sizes.workers, "--record", folder / f"{number}",
        )  # fmt: skip
        stages.append((_marked(folder / f"done-{number}", words),))
    return stages


def _train(sizes: Sizes, agent_id: str, kind: str, *words: object) -> TrainingStep:
    """Train an agent that is not there yet."""
    card = sizes.data / "models" / folder_name(agent_id) / CARD
    return _training(sizes, agent_id, ("train", kind, *words), card.exists)


def _training(sizes: Sizes, agent_id: str, words: tuple[object, ...], is_done: Callable[[], bool]) -> TrainingStep:
    named = ("--id", agent_id, "--name", NAMES[agent_id])
    whole = (*words, "--instead-of-shipped", *named, "--data", sizes.data)
    log = sizes.data / "logs" / f"{folder_name(agent_id)}.log"
    return TrainingStep(tuple(map(str, whole)), is_done, agent_id=agent_id, log=log)


def _marked(marker: Path, words: tuple[object, ...]) -> TrainingStep:
    """A step whose success is marked by a file."""
    return TrainingStep(tuple(map(str, words)), marker.exists, marker=marker)
