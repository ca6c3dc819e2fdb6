"""Learning a best response to many partners by PPO, on the leash of the imitated policy.

From the top: rooms are played with the present steering for a number of decisions; TorchRL's generalised advantages
and clipped objective improve it; the divergence from the imitated policy is added to the loss; and so on. The reward is
progress, the mean of NFD and TCR.
"""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from movingout.agents.errors import DataError
from movingout.agents.observation.features import Singles
from movingout.agents.policies.policy import CLIP
from movingout.agents.reinforcement.config import ResponseConfig
from movingout.agents.reinforcement.resume_file import read_resume, write_resume
from movingout.agents.reinforcement.rooms import EpisodeDistribution, PlayRoom, play_all
from movingout.agents.reinforcement.steered_policy import Critic, SteeredPolicy, divergence
from movingout.agents.training.run_folder import RESUME
from movingout.agents.training.run_output import append_losses, cut_losses
from movingout.maps.extras import needs_extra

with needs_extra("rl", "reinforcement learning"):
    from tensordict import TensorDict
    from tensordict.nn import TensorDictModule
    from torchrl.modules import IndependentNormal, ProbabilisticActor, ValueOperator
    from torchrl.objectives import ClipPPOLoss
    from torchrl.objectives.value import GAE

REWARD_UNIT = 0.02  # progress; brings rewards to about 1
_ACTION = "action_log_prob"


Tell = Callable[[dict[str, float]], None]


class BestResponse:
    """Everything that changes while a response is learned."""

    def __init__(self, policy: SteeredPolicy, distribution: EpisodeDistribution, config: ResponseConfig) -> None:
        torch.manual_seed(config.seed)
        torch.set_num_threads(config.threads)
        self.policy, self.config, self.round = policy, config, 0
        self.rooms = [
            PlayRoom(distribution, policy.spec, config.seed * 100_003 + number) for number in range(config.rooms)
        ]
        critic = Critic(policy)
        steering = TensorDictModule(_Steer(policy), in_keys=["observation"], out_keys=["loc", "scale"])
        actor = ProbabilisticActor(
            steering, in_keys=["loc", "scale"], distribution_class=IndependentNormal, return_log_prob=True
        )
        value = ValueOperator(critic, in_keys=["observation"])
        self._advantages = GAE(gamma=config.discount, lmbda=config.trace, value_network=value)
        self.losses = ClipPPOLoss(
            actor, value, clip_epsilon=config.clip_ratio, entropy_bonus=False, normalize_advantage=True
        )
        self._learned = nn.ModuleDict({"steering": policy.steering, "critic": critic})
        self.optimiser = torch.optim.AdamW(self._learned.parameters(), lr=config.rate, weight_decay=config.decay)

    def learn(self) -> dict[str, float]:
        """One round: play, then improve. Returns what is to be drawn as curves."""
        played, told = self._play()
        with torch.no_grad():
            self._advantages(played)
        rows = played.reshape(-1)
        for _ in range(self.config.passes):
            order = torch.randperm(len(rows))
            for start in range(0, len(rows), self.config.batch):
                told |= self._update(rows[order[start : start + self.config.batch]])
        self.round += 1
        return told

    def _play(self) -> tuple[Any, dict[str, float]]:
        """Decisions of all rooms as a TensorDict (K, T), and how it went."""
        inputs, results = [], []
        seen = self._features()
        for _ in range(self.config.decisions):
            with torch.inference_mode():
                loc, scale = self.policy.steer(seen)
                noise = loc + scale * torch.randn_like(loc)
                chunks = self.policy.chunks(seen, noise).numpy()
                logs = IndependentNormal(loc, scale).log_prob(noise)
            results.append(play_all(self.rooms, chunks))
            current = self._features()
            inputs.append((seen, noise, logs, _at_the_end(current, results[-1].last)))
            seen = current
        rewards = torch.tensor(np.stack([result.rewards for result in results], axis=1), dtype=torch.float32)
        over = torch.tensor(np.stack([result.over for result in results], axis=1)).bool()
        delivered = torch.tensor(np.stack([result.delivered for result in results], axis=1)).bool()
        seen, noise, logs, after = (_stacked(list(part)) for part in zip(*inputs, strict=True))
        told = {
            "progress per episode": float(rewards.sum() / over.sum().clamp(min=1)),
            "episodes": float(over.sum()),
            "all delivered": float(delivered.sum() / over.sum().clamp(min=1)),
        }
        # At the time limit there is nothing final about a state: what it is worth counts on.
        ends = {
            "done": over[..., None],
            "terminated": delivered[..., None],
            "truncated": (over & ~delivered)[..., None],
        }
        ends["reward"] = rewards[..., None] / REWARD_UNIT
        played = TensorDict(
            {"observation": seen, "action": noise, _ACTION: logs, "next": {"observation": after, **ends}},
            batch_size=rewards.shape,
        )
        return played, told

    def _features(self) -> Tensor:
        return torch.from_numpy(np.stack([room.features() for room in self.rooms]))

    def _update(self, rows: Any) -> dict[str, float]:
        losses = self.losses(rows)
        loc, scale = self.policy.steer(rows["observation"])
        length = divergence(loc, scale).mean()
        loss = losses["loss_objective"] + losses["loss_critic"] + self.config.leash * length
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(self._learned.parameters(), self.config.clip or 1e9)
        self.optimiser.step()
        return {"loss": float(loss.detach()), "divergence": float(length.detach())}

    def save(self, path: Path) -> None:
        """Everything needed to continue, as plain tensors; rooms start new episodes."""
        write_resume(path, self._learned, self.optimiser, {"round": torch.tensor(self.round)})

    def resume(self, path: Path) -> None:
        """Load what `save` wrote, if it is there. Raises DataError when it is damaged or of another policy."""
        if not path.exists():
            return
        others = read_resume(path, self._learned, self.optimiser)
        if "round" not in others:
            raise DataError(f"{path} is damaged or of another policy; choose another --id")
        self.round = int(others["round"])
        for number, room in enumerate(self.rooms):  # other episodes than those of the rounds before
            room.reseed(self.config.seed * 100_003 + number + 1_000_003 * self.round)


def learn_response(response: BestResponse, folder: Path, tell: Tell) -> int:
    """Learn to the end, continuing from the folder's resume file if there is one; returns the rounds of this run."""
    folder.mkdir(parents=True, exist_ok=True)
    response.resume(folder / RESUME)
    begun_at, begun = response.round, time.monotonic()
    cut_losses(folder, "update", begun_at)
    while response.round < response.config.updates:
        values = response.learn()
        seconds = round(time.monotonic() - begun, 1)
        append_losses(folder, {"update": response.round, "seconds": seconds, **values})
        tell({"update": response.round, **values})
        if response.round % response.config.evaluate_every == 0 or response.round == response.config.updates:
            response.save(folder / RESUME)
    return response.round - begun_at


class _Steer(nn.Module):
    """The steering as a module of observations; the imitated policy's weights are not among its own."""

    mean: Tensor
    scale: Tensor

    def __init__(self, policy: SteeredPolicy) -> None:
        super().__init__()
        self.steering = policy.steering
        self.register_buffer("mean", policy.mean)
        self.register_buffer("scale", policy.scale)

    def forward(self, observation: Tensor) -> tuple[Tensor, Tensor]:
        normal = ((observation - self.mean) * self.scale).clamp(-CLIP, CLIP)
        loc, scale = self.steering(normal.flatten(0, -2))
        shape = *observation.shape[:-1], -1
        return loc.reshape(shape), scale.reshape(shape)


def _at_the_end(current: Tensor, last: Sequence[Singles | None]) -> Tensor:
    """What decisions led to (K, D): the end of their episodes, where the rooms are already in the next."""
    rows = [row if seen is None else torch.from_numpy(seen) for row, seen in zip(current, last, strict=True)]
    return torch.stack(rows)


def _stacked(tensors: list[Tensor]) -> Tensor:
    """(K, T, ...) of T tensors (K, ...), outside of inference mode."""
    return torch.stack(tensors, dim=1).clone()
