"""Self-play over options: both seats share a network, which PPO improves (Schulman et al. 2017).

From the top: a round of episodes is played; advantages are worked out with the duration of each decision; TorchRL's
clipped objective improves the network; and so on. What is drawn in a round follows from the seed and the number of
the round, so that a run that was interrupted arrives at the same weights.
"""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from movingout.agents.errors import DataError
from movingout.agents.partners.options.features import SIZE, Singles
from movingout.agents.partners.options.option import MOST_OPTIONS
from movingout.agents.reinforcement.option_episodes import EpisodePlay, OptionChoice, advantages, play_episode
from movingout.agents.reinforcement.option_network import OptionNetwork
from movingout.agents.reinforcement.resume_file import read_resume, write_resume
from movingout.agents.reinforcement.self_play_config import SelfPlayConfig
from movingout.agents.training.run_folder import RESUME
from movingout.agents.training.run_output import append_losses, cut_losses, save_tensors
from movingout.maps import load_map
from movingout.maps.extras import needs_extra

with needs_extra("rl", "reinforcement learning"):
    from tensordict import TensorDict
    from tensordict.nn import TensorDictModule
    from torchrl.modules import ProbabilisticActor, ValueOperator
    from torchrl.objectives import ClipPPOLoss

EARLY_NETWORK = "young.safetensors"  # in the folder of a run
Tell = Callable[[dict[str, float]], None]


class SelfPlay:
    """Everything that changes while a policy over options learns."""

    def __init__(self, config: SelfPlayConfig, maps: Sequence[str]) -> None:
        torch.set_num_threads(config.threads)
        self.config, self.maps, self.round, self.decisions = config, tuple(maps), 0, 0
        self.made = 0  # rounds in this run
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(config.seed)
            self.network = OptionNetwork(config.width)
        self._losses = _losses(self.network, config)
        self._optimiser = torch.optim.Adam(self.network.parameters(), lr=config.rate)

    @property
    def episodes(self) -> int:
        """That were played to learn from."""
        return self.round * self.config.round_episodes

    def learn(self) -> dict[str, float]:
        """One round: play, then improve. Returns what is to be drawn as curves."""
        played = [self._play(self.episodes + number) for number in range(self.config.round_episodes)]
        rows = self._rows(played)
        generator = torch.Generator().manual_seed(self._drawn(0))
        entropy = self._improve(rows, generator)
        self.round += 1
        self.made += 1
        self.decisions += len(rows)
        return {
            "delivered": float(np.mean([one.delivered for one in played])),
            "progress": float(np.mean([one.progress for one in played])),
            "decisions per episode": len(rows) / len(played),
            "entropy": entropy,
        }

    def _drawn(self, *numbers: int) -> int:
        """A number that follows from the seed, the round and `numbers`."""
        return int(np.random.SeedSequence([self.config.seed, self.round, *numbers]).generate_state(1)[0] >> 1)

    def _play(self, episode: int) -> EpisodePlay:
        draw = np.random.default_rng([self.config.seed, episode])
        the_map = load_map(self.maps[int(draw.integers(len(self.maps)))])
        return play_episode(the_map, self._scores, int(draw.integers(2**31)), self.config)

    def _scores(self, features: Singles) -> Singles:
        with torch.inference_mode():
            scores: Singles = self.network(torch.from_numpy(features)[None], torch.ones(1, len(features)))[0].numpy()
        return scores

    def _rows(self, played: Sequence[EpisodePlay]) -> TensorDict:
        """All decisions of a round, with their advantages."""
        seats = [seat for one in played for seat in one.seats]
        choices = [choice for seat in seats for choice in seat.choices]
        options, offered = padded(choices)
        with torch.no_grad():
            logs = self.network(options, offered).log_softmax(dim=-1)
            values = self.network.value(options, offered)
        chosen = torch.tensor([choice.chosen for choice in choices])
        ends = np.cumsum([len(seat.choices) for seat in seats])[:-1]
        parts = zip(seats, np.split(values[:, 0].double().numpy(), ends), strict=True)
        gains = np.concatenate([advantages(seat, own, self.config) for seat, own in parts])
        advantage = torch.from_numpy(gains.astype(np.float32))[:, None]
        return TensorDict(
            {
                "options": options, "offered": offered, "action": chosen,
                "action_log_prob": logs.gather(1, chosen[:, None])[:, 0],
                "advantage": advantage, "value_target": advantage + values,
            },
            batch_size=[len(choices)],
        )  # fmt: skip

    def _improve(self, rows: TensorDict, generator: torch.Generator) -> float:
        """Make the passes over a round; returns the mean entropy [nat] of the choice."""
        entropies = []
        for _ in range(self.config.passes):
            order = torch.randperm(len(rows), generator=generator)
            for start in range(0, len(rows), self.config.batch):
                entropies.append(self._update(rows[order[start : start + self.config.batch]]))
        return float(np.mean(entropies))

    def _update(self, rows: TensorDict) -> float:
        losses = self._losses(rows)
        loss = losses["loss_objective"] + losses["loss_critic"] + losses["loss_entropy"]
        self._optimiser.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(self.network.parameters(), self.config.clip or 1e9)
        self._optimiser.step()
        return float(losses["entropy"].detach())

    def save(self, path: Path) -> None:
        """Everything needed to continue, as plain tensors."""
        others = {"round": torch.tensor(self.round), "decisions": torch.tensor(self.decisions)}
        write_resume(path, self.network, self._optimiser, others)

    def resume(self, path: Path) -> None:
        """Load what `save` wrote, if it is there. Raises DataError when it is damaged or of another policy."""
        if not path.exists():
            return
        others = read_resume(path, self.network, self._optimiser)
        if "decisions" not in others:
            raise DataError(f"{path} is damaged or of another policy; choose another --id")
        self.round, self.decisions = int(others["round"]), int(others["decisions"])


def padded(choices: Sequence[OptionChoice]) -> tuple[Tensor, Tensor]:
    """The options (N, MOST_OPTIONS, SIZE) of N decisions, and 1 where there is one (N, MOST_OPTIONS)."""
    options = np.zeros((len(choices), MOST_OPTIONS, SIZE), np.float32)
    offered = np.zeros((len(choices), MOST_OPTIONS), np.float32)
    for row, choice in enumerate(choices):
        options[row, : len(choice.options)] = choice.options
        offered[row, : len(choice.options)] = 1.0
    return torch.from_numpy(options), torch.from_numpy(offered)


def learn_self_play(learner: SelfPlay, folder: Path, tell: Tell) -> None:
    """Learn to the end, continuing from the folder's resume file if there is one."""
    folder.mkdir(parents=True, exist_ok=True)
    learner.resume(folder / RESUME)
    cut_losses(folder, "episodes", learner.episodes)
    begun, config = time.monotonic(), learner.config
    while learner.round < config.rounds:
        before = learner.episodes
        values = {"episodes": 0.0, **learner.learn()}
        values["episodes"] = float(learner.episodes)
        append_losses(folder, {**values, "seconds": round(time.monotonic() - begun, 1)})
        if before < config.young <= learner.episodes:
            save_tensors(folder / EARLY_NETWORK, learner.network.state_dict())
        learner.save(folder / RESUME)
        tell(values)


def read_early_network(folder: Path, width: int) -> OptionNetwork:
    """The copy that was kept early on. Raises DataError where it cannot be read."""
    network = OptionNetwork(width)
    try:
        network.load_state_dict(load_file(folder / EARLY_NETWORK))
    except (OSError, SafetensorError, RuntimeError) as error:
        raise DataError(f"{folder / EARLY_NETWORK} is missing or damaged; choose another --id") from error
    return network


def _losses(network: OptionNetwork, config: SelfPlayConfig) -> ClipPPOLoss:
    actor = ProbabilisticActor(
        TensorDictModule(network, in_keys=["options", "offered"], out_keys=["logits"]),
        in_keys=["logits"],
        distribution_class=torch.distributions.Categorical,
        return_log_prob=True,
    )
    return ClipPPOLoss(
        actor, ValueOperator(_Value(network), in_keys=["options", "offered"]), clip_epsilon=config.clip_ratio,
        entropy_bonus=True, entropy_coeff=config.entropy, critic_coeff=config.critic_weight, normalize_advantage=True,
    )  # fmt: skip


class _Value(nn.Module):
    """The critic as a module."""

    def __init__(self, network: OptionNetwork) -> None:
        super().__init__()
        self.network = network

    def forward(self, options: Tensor, offered: Tensor) -> Tensor:
        return self.network.value(options, offered)
