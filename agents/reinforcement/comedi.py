"""CoMeDi: conventions that differ, and an answer to all of them.

After Sarkar, Shih and Sadigh, "Diverse Conventions for Human-AI Collaboration", NeurIPS 2023. Conventions are learned
one after another. The first one learns by self-play; each further one from

- the reward of self-play,
- minus `cross` times that with the earlier convention with which it gets most (the most compatible, chosen anew in each
  round), so that it becomes another convention,
- plus `mixed` times that of self-play from states to which such play has led (mixed-play). Else it could spoil the game
  whenever it meets a stranger, which would look like a convention of its own.

At the end an agent learns to answer all of them by playing with each as often; it is what takes a seat. The paper on
Moving Out gives no numbers for CoMeDi; those here are ours.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.reinforcement.learning_room import RoomPairing
from movingout.agents.reinforcement.mappo import Mappo, learn_mappo
from movingout.agents.reinforcement.mappo_config import ComediConfig
from movingout.agents.reinforcement.tanh_actor import TanhActor
from movingout.maps.randomize import Split

TellOf = Callable[[str, dict[str, float]], None]


def learn_comedi(
    config: ComediConfig, spec: PolicySpec, maps: Sequence[str], split: Split | None, folder: Path, tell: TellOf,
    ray: str = "",
) -> list[Mappo]:  # fmt: skip
    """Learn the conventions, and last the answer to them; each has a folder of its own and is continued there."""
    conventions: list[TanhActor] = []
    learned: list[Mappo] = []
    for number in range(config.members + 1):
        answers = number == config.members
        pairings = answering(config) if answers else differing(config, number)
        one = Mappo(config.of_member(number), spec, maps, split, pairings, tuple(conventions), ray)
        name = "answer" if answers else f"convention-{number + 1}"
        learn_mappo(one, folder / name, lambda told, name=name: tell(name, told))  # type: ignore[misc]
        conventions.append(one.actor.requires_grad_(False))
        learned.append(one)
    return learned


def differing(config: ComediConfig, earlier: int) -> list[RoomPairing]:
    """The rooms of a convention: with earlier ones, a third each for self-play, cross-play and mixed-play."""
    if not earlier:
        return [RoomPairing()] * config.envs
    return [
        (
            RoomPairing(),
            RoomPairing("partner", -config.cross, room // 3 % earlier),
            RoomPairing("mixed", config.mixed, room // 3 % earlier),
        )[room % 3]
        for room in range(config.envs)
    ]


def answering(config: ComediConfig) -> list[RoomPairing]:
    """The rooms of the answer: with each convention as often."""
    return [RoomPairing("partner", 1.0, room % config.members) for room in range(config.envs)]
