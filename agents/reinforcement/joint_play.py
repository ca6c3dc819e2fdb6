"""Playing a round in all rooms: what both seats saw, did and got, as sequences to learn from."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from movingout.agents.reinforcement.learning_room import MODES, LearningRoom, RoomTick
from movingout.agents.reinforcement.tanh_actor import HIGH, LOW, TanhActor
from movingout.maps.extras import needs_extra

with needs_extra("rl", "reinforcement learning"):
    from tensordict import TensorDict
    from torchrl.modules import TanhNormal

RANGE = {"low": torch.tensor(LOW), "high": torch.tensor(HIGH)}


@dataclass(frozen=True, slots=True, eq=False)
class JointPlay:
    """What was played, with sequences in the order of rooms and in each blue, red."""

    rows: Any  # TensorDict (2 K, T), as TorchRL's losses take it
    learned: Tensor  # (2 K, T) of these, the ones that are learned from
    rewards: Tensor  # (2 K, T) before they are weighted
    scores: tuple[float, ...]  # official, of the episodes that ended

    def mean_reward(self, rooms: Sequence[int]) -> float:
        """Per tick and learning seat, in some of the rooms."""
        rows = [2 * room + seat for room in rooms for seat in (0, 1)]
        mine = self.learned[rows]
        return float(self.rewards[rows][mine].mean()) if mine.any() else 0.0


def play_round(
    rooms: Sequence[LearningRoom],
    actor: TanhActor,
    frozen: Sequence[TanhActor],
    ticks: int,
    generator: torch.Generator,
) -> JointPlay:
    """Play so many ticks in every room; all that is drawn comes from the generator."""
    steps: list[tuple[Tensor, Tensor, Tensor, Tensor, list[RoomTick]]] = []
    for _ in range(ticks):
        seen = _seen(rooms)
        learned = torch.tensor([room.learned for room in rooms])
        noise = torch.randn((len(rooms), 2, 4), generator=generator)
        with torch.no_grad():
            loc, scale = actor.moments(seen)
            raw = loc + scale * noise
            actions = actor.squashed(raw)
            logs = TanhNormal(loc, scale, **RANGE).log_prob(actions)
            played = _with_partners(rooms, frozen, seen, noise, actions)
        results = [room.step(own) for room, own in zip(rooms, played.numpy(), strict=True)]
        steps.append((seen, actions, logs, learned, results))
    return _sequences(rooms, steps)


def _with_partners(
    rooms: Sequence[LearningRoom], frozen: Sequence[TanhActor], seen: Tensor, noise: Tensor, actions: Tensor
) -> Tensor:
    """The actions (K, 2, 4) with those of frozen partners in their seats."""
    played = actions.clone()
    for number, partner in enumerate(frozen):
        places = [
            (index, room.partner_seat)
            for index, room in enumerate(rooms)
            if room.pairing.partner == number and room.partner_seat >= 0
        ]
        if places:
            index, seat = torch.tensor(places).T
            loc, scale = partner.moments(seen[index, seat])
            played[index, seat] = partner.squashed(loc + scale * noise[index, seat])
    return played


def _seen(rooms: Sequence[LearningRoom]) -> Tensor:
    return torch.from_numpy(np.stack([room.seen for room in rooms]))


def _sequences(
    rooms: Sequence[LearningRoom], steps: Sequence[tuple[Tensor, Tensor, Tensor, Tensor, list[RoomTick]]]
) -> JointPlay:
    seen, actions, logs, learned = (
        torch.stack(list(part), dim=2).flatten(0, 1) for part in zip(*_moved(steps), strict=True)
    )
    results = [[step[4][room] for step in steps] for room in range(len(rooms))]
    after = torch.tensor(np.array([[one.seen for one in row] for row in results])).transpose(1, 2)
    rewards = torch.tensor(np.array([[one.rewards for one in row] for row in results])).transpose(1, 2)
    over, finished = (
        torch.tensor([[getattr(one, name) for one in row] for row in results]).repeat_interleave(2, dim=0)[..., None]
        for name in ("over", "finished")
    )
    weights = torch.tensor([room.pairing.weight for room in rooms])[:, None, None]
    mode = F.one_hot(torch.tensor([MODES.index(room.pairing.mode) for room in rooms]), len(MODES)).float()
    shape = seen.shape[:2]
    rows = TensorDict(
        {
            "observation": seen,
            "state": _states(seen.reshape(-1, 2, *seen.shape[1:]), mode),
            "action": actions,
            "action_log_prob": logs,
            "next": {
                "state": _states(after, mode), "reward": (weights * rewards).flatten(0, 1)[..., None],
                "done": over, "terminated": finished,
            },
        },
        batch_size=shape,
    )  # fmt: skip
    scores = tuple(one.score for row in results for one in row if one.over)
    return JointPlay(rows, learned, rewards.flatten(0, 1), scores)


def _moved(steps: Sequence[tuple[Any, ...]]) -> list[tuple[Tensor, ...]]:
    return [tuple(step[:4]) for step in steps]


def _states(seen: Tensor, mode: Tensor) -> Tensor:
    """What the critic sees (2 K, T, 2 D + modes), from observations (K, 2, T, D) and modes (K, modes)."""
    modes = mode[:, None, None, :].expand(*seen.shape[:3], -1)
    return torch.cat((seen, seen.flip(1), modes), dim=-1).flatten(0, 1)
