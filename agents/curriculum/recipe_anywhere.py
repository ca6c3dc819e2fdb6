"""The recipe of the agents that play anywhere: what is trained, from what, and in which order.

Maps without end instead of the paper's twelve, partners of many makes instead of one house's people, and observations
without absolute places. `recipe_anywhere` reads from top to bottom like `curriculum.recipe`; what has been done is
skipped.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from movingout.agents.checkpoint.checkpoint import CARD, folder_name
from movingout.agents.curriculum.steps import Stage, TrainingStep, count_option, trained
from movingout.agents.data.dagger import EXPERT
from movingout.agents.errors import AgentError, DataError
from movingout.agents.partners.families import is_group, test_people_caution
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
    ray: str = ""  # address of a Ray cluster that plays instead of processes here
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
    seeds: int = count_option(1, "trainings of Diffusion Policy on all labels and of BASS on it, with seeds 0, 1, …")


def recipe_anywhere(sizes: AnywhereSizes) -> list[Stage]:
    """Maps, labels and agents, from nothing."""
    labels, listed = sizes.data / "anywhere" / "labels", sizes.data / "anywhere" / "maps.txt"
    stages: list[Stage] = [(_maps(sizes, listed),)]
    for number in range(sizes.rounds + 1):
        stages += [(step,) for step in _label(sizes, labels, listed, number)]
        if number < sizes.rounds:
            stages.append((_diffusion(sizes, LEARNER_ANY, labels, sizes.updates * (number + 1), 0),))
    policies = enumerate(of_seeds(DP_ANY, sizes.seeds))
    stages.append(tuple(_diffusion(sizes, name, labels, sizes.policy_updates, seed) for seed, name in policies))
    return [*stages, *_response(sizes, listed), *_bass(sizes, labels, listed)]


def check_partners(partners: str) -> None:
    """Raises DataError for partners that `demos label` does not know, or that are for tests alone."""
    if partners in ("A", "B", "AB"):
        return
    if partners != "C" and not is_group(partners):
        raise DataError(
            f"--partners {partners}: known are A, B, AB, a family as family:greedy, families, families:without-greedy, "
            "@FILE"
        )
    try:
        for_tests = test_people_caution([partners])
    except AgentError as error:
        raise DataError(f"--partners: {error}") from error
    if for_tests:
        raise DataError(
            f"--partners {partners}: people of C are for tests and never trained with; A, B or AB are for training"
        )


def of_seeds(agent_id: str, seeds: int) -> list[str]:
    """The ids of an agent trained with seeds 0, 1, …: `dp@any`, `dp@any-1`, …"""
    return [f"{agent_id}-{seed}" if seed else agent_id for seed in range(seeds)]


def _response(sizes: AnywhereSizes, listed: Path) -> list[Stage]:
    """Reinforcement learning on the leash of the imitated policy, reported apart from it; none for 0 rounds."""
    partners = [f"people:{name}" for name in sizes.partners] if set(sizes.partners) <= set("AB") else [sizes.partners]
    words = (
        "train", "response", "--base", DP_ANY, "--map", f"@{listed}", "--partners", *partners, "--ticks", sizes.ticks,
        "--go-on", "--updates", sizes.response_rounds, "--threads", sizes.workers,
    )  # fmt: skip
    is_done = trained(sizes.data / "models", RESPONSE_ANY, sizes.response_rounds)
    return [(_training(sizes, RESPONSE_ANY, words, is_done),)] if sizes.response_rounds else []


def _bass(sizes: AnywhereSizes, labels: Path, listed: Path) -> list[Stage]:
    """A value, learned from labels and own play; then again, from what it led to. The engine itself simulates."""
    plays = sizes.data / "anywhere" / "plays"
    alone, firsts, again, lasts = [], [], [], []
    for seed, names in enumerate(
        zip(*(of_seeds(one, sizes.seeds) for one in (DP_ANY, FIRST_ANY, BASS_ANY)), strict=True)
    ):
        base, first, last = names
        own, led_to = (plays / folder_name(name) for name in (base, first))
        alone.append(_plays(sizes, base, own, listed))
        firsts.append(_valued(sizes, first, base, seed, labels, own))
        again.append(_plays(sizes, first, led_to, listed))
        lasts.append(_valued(sizes, last, base, seed, labels, own, led_to))
    return [*((one,) for one in alone), tuple(firsts), *((one,) for one in again), tuple(lasts)]


def _valued(sizes: AnywhereSizes, agent_id: str, base: str, seed: int, *folders: Path) -> TrainingStep:
    """BASS on a policy, its value learned from folders of episodes."""
    words = (
        "train", "bass", *folders, "--base", base, "--dynamics", "engine", "--sub-steps", 10,
        "--value-layout", "relative-v1", "--caution", 1, "--own", 4, "--partner", 2,
        "--value-updates", sizes.value_updates, "--seed", seed,
        "--threads", sizes.workers if sizes.seeds == 1 else 1,
    )  # fmt: skip
    return _training(sizes, agent_id, words)


def _plays(sizes: AnywhereSizes, agent_id: str, folder: Path, listed: Path) -> TrainingStep:
    """Episodes in which an agent plays and nobody helps it: it is its own expert, with occasional slips of its hand."""
    words = (
        "demos", "label", "--map", f"@{listed}:{min(sizes.play_maps, 3 * sizes.maps)}", "--learner", agent_id,
        "--expert", agent_id, "--population", sizes.partners, "--episodes", 1, "--seed", 100, "--ticks", sizes.ticks,
        *_where(sizes), "--out", folder,
    )  # fmt: skip
    marker = folder / "done"
    return TrainingStep(tuple(map(str, words)), marker.exists, marker=marker)


def _training(
    sizes: AnywhereSizes, agent_id: str, words: tuple[object, ...], is_done: Callable[[], bool] | None = None
) -> TrainingStep:
    """Train an agent; `is_done` tells when it has been, without it that there is one."""
    card = sizes.data / "models" / folder_name(agent_id) / CARD
    named = ("--id", agent_id, "--name", _name(agent_id))
    whole = (*words, "--instead-of-shipped", *named, "--data", sizes.data)
    log = sizes.data / "logs" / f"{folder_name(agent_id)}.log"
    return TrainingStep(tuple(map(str, whole)), is_done or card.exists, agent_id=agent_id, log=log)


def _name(agent_id: str) -> str:
    """What the lobby calls an agent, also one of another seed than 0."""
    base, _, seed = agent_id.partition("any-")
    return NAMES[agent_id] if agent_id in NAMES else f"{NAMES[base + 'any']}, seed {seed}"


def _where(sizes: AnywhereSizes) -> tuple[object, ...]:
    """The options of `demos` that say who plays."""
    return ("--workers", sizes.workers, *(("--ray", sizes.ray) if sizes.ray else ()))


def _maps(sizes: AnywhereSizes, listed: Path) -> TrainingStep:
    """The list of maps on which a pair of experts delivers everything."""
    words = "demos", "prove", "--split", "training", "--count", sizes.maps, *_where(sizes), "--out", listed
    return TrainingStep(tuple(map(str, words)), lambda: len(read_table(listed)) >= 3 * sizes.maps)


def _label(sizes: AnywhereSizes, labels: Path, listed: Path, number: int) -> list[TrainingStep]:
    """A round of labelling: two episodes per map by the expert alone, then one per map by turns with the learner."""
    learner, episodes = (EXPERT, 2) if number == 0 else (LEARNER_ANY, 1)
    steps = []
    for name, maps in (("generated", f"@{listed}"), ("paper", "all,all:symmetries")):
        folder = labels / f"{name}-{number}"
        words = (
            "demos", "label", "--map", maps, "--learner", learner, "--population", sizes.partners,
            "--episodes", episodes, "--seed", number, "--ticks", sizes.ticks, *_where(sizes),
            "--out", folder,
        )  # fmt: skip
        marker = folder / "done"
        if name == "generated" or sizes.paper_maps:
            steps.append(TrainingStep(tuple(map(str, words)), marker.exists, marker=marker))
    return steps


def _diffusion(sizes: AnywhereSizes, agent_id: str, labels: Path, total: int, seed: int) -> TrainingStep:
    """Diffusion Policy, trained on to `total` updates with the labels there are by now."""
    words = (
        "train", "dp", labels, *SEEN, "--go-on", "--updates", total, "--width", sizes.width, "--batch", sizes.batch,
        "--seed", seed, "--threads", sizes.workers if agent_id == LEARNER_ANY or sizes.seeds == 1 else 1,
        "--population", f"a scripted expert beside {sizes.partners} on generated maps",
    )  # fmt: skip
    return _training(sizes, agent_id, words, trained(sizes.data / "models", agent_id, total))
