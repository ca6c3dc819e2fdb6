"""A round in one room: both seats are played by the learner, or one by a frozen partner."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from movingout.agents.reinforcement.learning_room import LearningRoom, Singles
from movingout.agents.reinforcement.tanh_actor import TanhActor

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class RoomPlay:
    """T ticks of a room, in plain arrays: they come from other machines, too."""

    seen: Singles  # (T, 2, D)
    loc: Singles  # (T, 2, 4) of what the learner would have drawn for each seat, before squashing
    scale: Singles  # (T, 2, 4)
    drawn: Singles  # (T, 2, 4) what it drew, before squashing
    learned: Bools  # (T, 2) whether the seat is learned from
    rewards: Singles  # (T, 2)
    over: Bools  # (T,)
    finished: Bools  # (T,) everything delivered
    after: Singles  # (T, 2, D) seen after the tick
    scores: tuple[float, ...]  # official, of the episodes that ended


def play_room(room: LearningRoom, actor: TanhActor, frozen: Sequence[TanhActor], noise: Tensor) -> RoomPlay:
    """Play with noise (T, 2, 4). The two seats alone are a batch, so a room plays the same beside any others."""
    chosen: list[tuple[Singles, Tensor, Tensor, Tensor]] = []
    learned, results = [], []
    with torch.no_grad():
        for own in noise:
            seen = torch.from_numpy(room.seen)
            loc, scale = actor.moments(seen)
            drawn = loc + scale * own
            chosen.append((room.seen, loc, scale, drawn))
            learned.append(room.learned)
            results.append(room.step(_with_partner(room, frozen, seen, own, actor.squashed(drawn)).numpy()))
    rows = (np.stack([np.asarray(one) for one in part]) for part in zip(*chosen, strict=True))
    seen_rows, locs, scales, drawn_rows = rows
    return RoomPlay(
        seen_rows, locs, scales, drawn_rows,
        learned=np.array(learned),
        rewards=np.array([one.rewards for one in results]),
        over=np.array([one.over for one in results]),
        finished=np.array([one.finished for one in results]),
        after=np.array([one.seen for one in results]),
        scores=tuple(one.score for one in results if one.over),
    )  # fmt: skip


def _with_partner(
    room: LearningRoom, frozen: Sequence[TanhActor], seen: Tensor, noise: Tensor, actions: Tensor
) -> Tensor:
    """The actions (2, 4), with that of a frozen partner in its seat."""
    seat = room.partner_seat
    if seat < 0:
        return actions
    partner, played = frozen[room.pairing.partner], actions.clone()
    loc, scale = partner.moments(seen[seat])
    played[seat] = partner.squashed(loc + scale * noise[seat])
    return played
