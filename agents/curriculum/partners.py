"""The recipe of learned partners: clones of several seeds and ages, for the family `clone`.

They learn from the labels that `agents.curriculum.recipe` makes. A young one has seen a tenth of the updates of an old
one, so it hesitates and errs more.
"""

from movingout.agents.checkpoint.checkpoint import CARD, folder_name
from movingout.agents.curriculum.recipe import Sizes
from movingout.agents.curriculum.steps import Stage, TrainingStep
from movingout.agents.partners.families import CLONE_SEEDS, aged_clone

AGES = {"young": 0.1, "old": 1.0}  # share of the updates of `make agents`


def clone_stage(sizes: Sizes) -> Stage:
    """One training for each seed and age; none waits for another."""
    return tuple(_clone(sizes, seed, age) for seed in range(CLONE_SEEDS) for age in AGES)


def _clone(sizes: Sizes, seed: int, age: str) -> TrainingStep:
    agent_id = aged_clone(seed, age)
    updates = max(round(AGES[age] * sizes.policy_updates), 1)
    words = (
        "train", "dp", sizes.data / "labels", "--id", agent_id, "--name", f"Clone {seed}, {age}", "--seed", seed,
        "--updates", updates, "--width", sizes.width, "--batch", sizes.batch, "--data", sizes.data,
        "--population", "a scripted expert beside scripted people of A and B",
    )  # fmt: skip
    card = sizes.data / "models" / folder_name(agent_id) / CARD
    log = sizes.data / "logs" / f"{folder_name(agent_id)}.log"
    return TrainingStep(tuple(map(str, words)), card.exists, agent_id=agent_id, log=log)
