"""A round in all rooms: what both seats saw, did and got, as sequences to learn from."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from movingout.agents.reinforcement.learning_room import MODES, RoomPairing
from movingout.agents.reinforcement.room_play import RoomPlay
from movingout.agents.reinforcement.squashed_normal import SquashedNormal
from movingout.maps.extras import needs_extra

with needs_extra("rl", "reinforcement learning"):
    from tensordict import TensorDict


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


def joint_play(plays: Sequence[RoomPlay], pairings: Sequence[RoomPairing]) -> JointPlay:
    """What was played in all rooms, as sequences to learn from."""
    seen, loc, scale, drawn, learned, rewards, after = (
        torch.from_numpy(np.array([getattr(one, name) for one in plays])).transpose(1, 2)  # (K, 2, T, …)
        for name in ("seen", "loc", "scale", "drawn", "learned", "rewards", "after")
    )
    over, finished = (
        torch.from_numpy(np.array([getattr(one, name) for one in plays])).repeat_interleave(2, dim=0)[..., None]
        for name in ("over", "finished")
    )
    logs = SquashedNormal(loc, scale).log_prob(drawn)  # type: ignore[no-untyped-call]  # torch tells no types
    weights = torch.tensor([one.weight for one in pairings])[:, None, None]
    mode = F.one_hot(torch.tensor([MODES.index(one.mode) for one in pairings]), len(MODES)).float()
    rows = TensorDict(
        {
            "observation": seen.flatten(0, 1),
            "state": _states(seen, mode),
            "action": drawn.flatten(0, 1),
            "action_log_prob": logs.flatten(0, 1),
            "next": {
                "state": _states(after, mode), "reward": (weights * rewards).flatten(0, 1)[..., None],
                "done": over, "terminated": finished,
            },
        },
        batch_size=over.shape[:2],
    )  # fmt: skip
    scores = tuple(score for one in plays for score in one.scores)
    return JointPlay(rows, learned.flatten(0, 1), rewards.flatten(0, 1), scores)


def _states(seen: Tensor, mode: Tensor) -> Tensor:
    """What the critic sees (2 K, T, 2 D + modes), from observations (K, 2, T, D) and modes (K, modes)."""
    modes = mode[:, None, None, :].expand(*seen.shape[:3], -1)
    return torch.cat((seen, seen.flip(1), modes), dim=-1).flatten(0, 1)
